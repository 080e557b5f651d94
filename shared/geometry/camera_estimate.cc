#include "shared/geometry/camera_estimate.h"

namespace touchline::geometry {

std::string_view name(Evidence evidence) {
  switch (evidence) {
    case Evidence::kLost:
      return "lost";
    case Evidence::kLines:
      return "lines";
    case Evidence::kPlate:
      return "plate";
    case Evidence::kEncoder:
      return "encoder";
    case Evidence::kPeers:
      return "peers";
  }
  return "lost";
}

}  // namespace touchline::geometry
