#include "shared/codec/camera_view.h"

namespace touchline::codec {

std::string_view name(PartKind kind) {
  switch (kind) {
    case PartKind::kMatte:
      return "matte";
    case PartKind::kPartial:
      return "partial";
    case PartKind::kTiles:
      return "tiles";
    case PartKind::kPlateTile:
      return "plate-tile";
  }
  return "unknown";
}

}  // namespace touchline::codec
