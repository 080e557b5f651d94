#include "hub/scene/hull.h"

namespace touchline::scene {

std::string_view name(Rendition rendition) {
  switch (rendition) {
    case Rendition::kRefined:
      return "refined";
    case Rendition::kHull:
      return "hull";
    case Rendition::kBillboard:
      return "billboard";
    case Rendition::kAbsent:
      return "absent";
  }
  return "unknown";
}

}  // namespace touchline::scene
