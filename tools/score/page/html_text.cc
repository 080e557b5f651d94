#include "tools/score/page/html_text.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

namespace touchline::score::page {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string figure(double value, int decimals) {
  if (!std::isfinite(value)) return "&#8211;";
  return fmt::format("{:.{}f}", value, decimals);
}

std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
    out += kept ? c : '_';
  }
  return out;
}

}  // namespace touchline::score::page
