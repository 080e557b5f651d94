#include "shared/base/ids.h"

#include <algorithm>

namespace touchline::base {

bool is_valid(const CameraId& id) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  return !id.value.empty() && id.value.size() <= 32 &&
         std::all_of(id.value.begin(), id.value.end(), allowed);
}

}  // namespace touchline::base
