#include "shared/wire/link_options.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <string_view>

#include "shared/base/bounds.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;

bool is_ipv4(std::string_view text) {
  int parts = 0;
  while (true) {
    const std::size_t dot = text.find('.');
    const std::string_view part = text.substr(0, dot);
    int value = -1;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || part.size() > 3 || value < 0 ||
        value > 255) {
      return false;
    }
    ++parts;
    if (dot == std::string_view::npos) return parts == 4;
    if (parts == 4) return false;
    text.remove_prefix(dot + 1);
  }
}

base::Status check_addresses(std::string_view field, const std::vector<std::string>& addresses) {
  if (addresses.size() > 64) {
    return base::fail(ErrorKind::kConfiguration, fmt::format("link.{}", field),
                      fmt::format("{} addresses, at most 64 are taken", addresses.size()));
  }
  for (const std::string& address : addresses) {
    if (!is_ipv4(address)) {
      return base::fail(ErrorKind::kConfiguration, fmt::format("link.{}", field),
                        fmt::format("\"{}\" is no IPv4 address", address),
                        "write numbers, e.g. \"10.0.0.2\"");
    }
  }
  return {};
}

}  // namespace

base::Status LinkOptions::validate() const {
  if (auto ok = base::in_bounds("link.domain", domain, 0, 230); !ok) return ok;
  if (tag.size() > 64) {
    return base::fail(ErrorKind::kConfiguration, "link.tag",
                      fmt::format("{} characters, at most 64 are taken", tag.size()));
  }
  for (const char c : tag) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.') {
      return base::fail(ErrorKind::kConfiguration, "link.tag",
                        "has characters other than letters, digits, '-', '_' and '.'");
    }
  }
  if (interfaces.empty()) {
    return base::fail(ErrorKind::kConfiguration, "link.interfaces", "names no interface",
                      "give the IPv4 address of the interface to use");
  }
  if (auto ok = check_addresses("interfaces", interfaces); !ok) return ok;
  if (auto ok = check_addresses("peers", peers); !ok) return ok;
  if (auto ok = base::in_bounds("link.participants_per_peer", participants_per_peer, 1, 100); !ok)
    return ok;
  if (auto ok = base::in_bounds("link.lease", lease.count(), 500, 60'000); !ok) return ok;
  if (auto ok = base::in_bounds("link.status_deadline", status_deadline.count(), 100, 60'000); !ok)
    return ok;
  if (auto ok = base::in_bounds("link.frame_lifespan", frame_lifespan.count(), 20, 10'000); !ok)
    return ok;
  if (auto ok = base::in_bounds("link.keep_last", keep_last, 1, 256); !ok) return ok;
  if (auto ok = base::in_bounds("link.max_mbit_s", max_mbit_s, 1, 16'000); !ok) return ok;
  if (auto ok = base::in_bounds("link.credit_bytes", static_cast<std::int64_t>(credit_bytes),
                                64 << 10, 256 << 20);
      !ok) {
    return ok;
  }
  if (auto ok =
          base::in_bounds("link.socket_buffer_bytes", socket_buffer_bytes, 64 << 10, 64 << 20);
      !ok) {
    return ok;
  }
  return base::in_bounds("link.message_bytes", message_bytes, 1200, 65'000);
}

}  // namespace touchline::wire
