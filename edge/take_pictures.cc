#include "edge/take_pictures.h"

#include <cstdint>

#include "shared/base/bounds.h"

namespace touchline::edge {

base::Status TakePicturesOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("look_s", look_s, 0, 3600), base::in_bounds("pictures", pictures, 2, 1000),
        base::in_bounds("mib", mib, 16, 65536)})
    if (!status) return status;
  return {};
}

std::vector<image::FramePtr> take_pictures(capture::FrameSource& source, base::FrameRate rate,
                                           const TakePicturesOptions& options,
                                           std::stop_token stop) {
  std::vector<image::FramePtr> kept;
  std::uint64_t bytes = 0;
  const auto bytes_of = [](const image::Frame& frame) {
    std::uint64_t sum = 0;
    for (const auto& plane : frame.planes) sum += plane.size() * sizeof(std::uint16_t);
    return sum;
  };
  const auto most_bytes = static_cast<std::uint64_t>(options.mib) << 20;
  const auto most = static_cast<std::size_t>(options.pictures);
  std::int64_t apart = 1;
  for (std::int64_t i = 0; static_cast<double>(i) < options.look_s * rate.hz(); ++i) {
    auto frame = source.next(stop);
    if (!frame || !*frame) break;
    if (i % apart != 0) continue;
    bytes += bytes_of(***frame);
    kept.push_back(std::move(**frame));
    if (kept.size() <= 2 || (kept.size() <= most && bytes <= most_bytes)) continue;
    // Every other one goes, the first stays.
    std::size_t count = 0;
    bytes = 0;
    for (std::size_t k = 0; k < kept.size(); k += 2) {
      bytes += bytes_of(*kept[k]);
      kept[count++] = std::move(kept[k]);
    }
    kept.resize(count);
    apart *= 2;
  }
  return kept;
}

}  // namespace touchline::edge
