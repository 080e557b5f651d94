#include "shared/recording/ffmpeg_internal.h"

#include <array>

extern "C" {
#include <libavutil/error.h>
#include <libavutil/log.h>
}

namespace touchline::recording {

std::string ffmpeg_text(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

void quiet_ffmpeg() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace touchline::recording
