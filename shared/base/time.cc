#include "shared/base/time.h"

#include <fmt/format.h>

#include <charconv>

namespace touchline::base {
namespace {

std::optional<std::int64_t> parse_int(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

__extension__ using Int128 = __int128;  // frame * 1e9 * den does not fit 64 bits

std::int64_t nominal_fps(FrameRate rate) { return (rate.num + rate.den / 2) / rate.den; }

std::int64_t frames_since_midnight(const Timecode& timecode, std::int64_t fps) {
  const std::int64_t minutes = timecode.hours * 60 + timecode.minutes;
  std::int64_t count = (minutes * 60 + timecode.seconds) * fps + timecode.frames;
  if (timecode.drop_frame) count -= fps / 15 * (minutes - minutes / 10);
  return count;
}

}  // namespace

Result<FrameRate> parse_frame_rate(const std::string& text) {
  const auto slash = text.find('/');
  const auto num = parse_int(std::string_view(text).substr(0, slash));
  const auto den = slash == std::string::npos ? std::optional<std::int64_t>(1)
                                              : parse_int(std::string_view(text).substr(slash + 1));
  if (!num || !den || *num <= 0 || *den <= 0 || *num > 1'000'000'000 || *den > 1'000'000'000) {
    return fail(ErrorKind::kFormat, "frame rate", "'" + text + "' is not a frame rate",
                "write frames per second as a fraction, e.g. 25/1 or 30000/1001");
  }
  return FrameRate{*num, *den};
}

std::string to_string(FrameRate rate) { return fmt::format("{}/{}", rate.num, rate.den); }

MediaTime frame_time(MediaTime start, FrameRate rate, std::int64_t frame) {
  const Int128 numerator = static_cast<Int128>(frame) * 1'000'000'000 * rate.den;
  const Int128 half = rate.num / 2;
  const Int128 rounded =
      numerator >= 0 ? (numerator + half) / rate.num : -((-numerator + half) / rate.num);
  return MediaTime{start.ns + static_cast<std::int64_t>(rounded)};
}

Result<Timecode> parse_timecode(const std::string& text) {
  const auto bad = [&] {
    return fail(ErrorKind::kFormat, "timecode", "'" + text + "' is not a timecode",
                "write hh:mm:ss:ff, e.g. 10:00:00:00");
  };
  if (text.size() != 11 || text[2] != ':' || text[5] != ':' || (text[8] != ':' && text[8] != ';')) {
    return bad();
  }
  const std::string_view view(text);
  const auto hours = parse_int(view.substr(0, 2));
  const auto minutes = parse_int(view.substr(3, 2));
  const auto seconds = parse_int(view.substr(6, 2));
  const auto frames = parse_int(view.substr(9, 2));
  if (!hours || !minutes || !seconds || !frames) return bad();
  if (*hours < 0 || *hours > 23 || *minutes < 0 || *minutes > 59 || *seconds < 0 || *seconds > 59 ||
      *frames < 0) {
    return bad();
  }
  return Timecode{static_cast<int>(*hours), static_cast<int>(*minutes), static_cast<int>(*seconds),
                  static_cast<int>(*frames), text[8] == ';'};
}

std::string to_string(const Timecode& timecode) {
  return fmt::format("{:02}:{:02}:{:02}{}{:02}", timecode.hours, timecode.minutes, timecode.seconds,
                     timecode.drop_frame ? ';' : ':', timecode.frames);
}

Timecode advance(const Timecode& start, FrameRate rate, std::int64_t frames) {
  const std::int64_t fps = nominal_fps(rate);
  const std::int64_t dropped = start.drop_frame ? fps / 15 : 0;
  const std::int64_t per_ten_minutes = 600 * fps - 9 * dropped;
  const std::int64_t day = 144 * per_ten_minutes;
  std::int64_t count = (frames_since_midnight(start, fps) + frames) % day;
  if (count < 0) count += day;
  if (start.drop_frame) {
    const std::int64_t tens = count / per_ten_minutes;
    const std::int64_t rest = count % per_ten_minutes;
    count += 9 * dropped * tens;
    if (rest >= dropped) count += dropped * ((rest - dropped) / (60 * fps - dropped));
  }
  return Timecode{static_cast<int>(count / (3600 * fps)), static_cast<int>(count / (60 * fps) % 60),
                  static_cast<int>(count / fps % 60), static_cast<int>(count % fps),
                  start.drop_frame};
}

}  // namespace touchline::base
