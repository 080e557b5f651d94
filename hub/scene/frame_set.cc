#include "hub/scene/frame_set.h"

namespace touchline::scene {

std::string_view name(AbsentReason reason) {
  switch (reason) {
    case AbsentReason::kNotYet:
      return "not-yet";
    case AbsentReason::kLate:
      return "late";
    case AbsentReason::kLostInTransit:
      return "lost-in-transit";
    case AbsentReason::kEnded:
      return "ended";
    case AbsentReason::kUndecodable:
      return "undecodable";
  }
  return "unknown";
}

}  // namespace touchline::scene
