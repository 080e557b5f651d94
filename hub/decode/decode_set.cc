#include "hub/decode/decode_set.h"

#include <set>
#include <utility>

#include "shared/codec/view_codec.h"

namespace touchline::decode {

base::Result<DecodedSet> decode_set(const scene::FrameSet& set, const codec::DecodeLimits& limits) {
  DecodedSet decoded;
  decoded.instant = set.instant;
  std::set<base::CameraId> seen;
  for (const scene::FrameSetEntry& entry : set.entries) {
    if (!seen.insert(entry.camera).second) {
      return base::fail(base::ErrorKind::kArgument, entry.camera.value,
                        "occurs twice in a frame set");
    }
    if (const auto* absent = std::get_if<scene::Absent>(&entry.view)) {
      decoded.absent.push_back({entry.camera, absent->reason, std::nullopt});
      continue;
    }
    const auto& encoded = std::get<codec::EncodedView>(entry.view);
    if (encoded.id.camera != entry.camera) {
      return base::fail(base::ErrorKind::kArgument, entry.camera.value,
                        "holds a view of " + encoded.id.camera.value);
    }
    auto view = codec::decode(encoded, limits);
    if (view) {
      decoded.views.push_back(std::move(*view));
    } else {
      decoded.absent.push_back(
          {entry.camera, scene::AbsentReason::kUndecodable, std::move(view.error())});
    }
  }
  return decoded;
}

}  // namespace touchline::decode
