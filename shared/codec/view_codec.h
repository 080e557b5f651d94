// A camera's view of one instant <-> its parts as bytes.
#pragma once

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/tile_codec.h"

namespace touchline::codec {

struct EncodeOptions {
  TileOptions tiles;
  // Of all parts of a view: 45 Mbit/s at 50 frames a second, less what the wire adds. Tiles make do
  // with what matte and partial leave; 0 = no bound.
  std::size_t max_bytes = 108'000;
  base::Status validate() const;
};

// Parts in the order matte, partial, tiles; a part that the view lacks is absent. The error's
// `where` names camera, sequence and part.
base::Result<EncodedView> encode(const CameraView& view, const EncodeOptions& options = {});

// Unknown kinds of part are skipped; a known kind that occurs twice, has an unknown version or does
// not decode, and a matte whose size is not that of the camera model (unless the camera is lost),
// make the whole view an error.
base::Result<CameraView> decode(const EncodedView& encoded, const DecodeLimits& limits = {});

}  // namespace touchline::codec
