#include "hub/render/stadium.h"

namespace touchline::render {

Stadium estimate_stadium(const pitch::PitchModel& pitch,
                         const std::map<base::CameraId, image::PlateSnapshot>&,
                         const StadiumOptions& options) {
  return default_stadium(pitch, options);
}

}  // namespace touchline::render
