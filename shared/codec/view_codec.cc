#include "shared/codec/view_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/codec/matte_codec.h"
#include "shared/codec/partial_codec.h"

namespace touchline::codec {
namespace {

using base::ErrorKind;

// The error with camera, sequence and part before its own place.
base::Error at(const base::FrameId& id, base::Error error) {
  error.where = fmt::format("{}#{} {}", id.camera.value, id.sequence, error.where);
  return error;
}

// The tile options with what the parts so far leave of the view's bytes.
TileOptions within_budget(const EncodeOptions& options, const EncodedView& encoded) {
  TileOptions tiles = options.tiles;
  if (options.max_bytes == 0) return tiles;
  std::size_t used = 0;
  for (const EncodedPart& part : encoded.parts) used += part.bytes.size();
  const std::size_t left = options.max_bytes > used ? options.max_bytes - used : 1;
  tiles.max_bytes = tiles.max_bytes == 0 ? left : std::min(tiles.max_bytes, left);
  return tiles;
}

// Takes what a part decoded to, or passes the error on.
template <typename T>
base::Status take(const base::FrameId& id, base::Result<T> decoded, std::optional<T>& into,
                  const EncodedPart& part) {
  if (into) {
    return base::fail(
        at(id, {ErrorKind::kFormat, std::string(name(part.kind)), "occurs twice", {}}));
  }
  if (!decoded) return base::fail(at(id, std::move(decoded.error())));
  into = std::move(*decoded);
  return {};
}

}  // namespace

base::Status EncodeOptions::validate() const { return tiles.validate(); }

base::Result<EncodedView> encode(const CameraView& view, const EncodeOptions& options) {
  EncodedView encoded{view.id, view.stamp, view.estimate, {}};
  if (view.matte) {
    auto bytes = encode_matte(*view.matte);
    if (!bytes) return base::fail(at(view.id, bytes.error()));
    encoded.parts.push_back({PartKind::kMatte, kMatteVersion, std::move(*bytes)});
  }
  if (view.partial) {
    auto bytes = encode_partial(*view.partial);
    if (!bytes) return base::fail(at(view.id, bytes.error()));
    encoded.parts.push_back({PartKind::kPartial, kPartialVersion, std::move(*bytes)});
  }
  if (view.tiles) {
    auto bytes = encode_tiles(*view.tiles, within_budget(options, encoded));
    if (!bytes) return base::fail(at(view.id, bytes.error()));
    encoded.parts.push_back({PartKind::kTiles, kTilesVersion, std::move(*bytes)});
  }
  return encoded;
}

base::Result<CameraView> decode(const EncodedView& encoded, const DecodeLimits& limits) {
  CameraView view{encoded.id, encoded.stamp, encoded.estimate, {}, {}, {}};
  for (const EncodedPart& part : encoded.parts) {
    base::Status status;
    switch (part.kind) {
      case PartKind::kMatte:
        status = take(view.id, decode_matte(part.bytes, part.version, limits), view.matte, part);
        break;
      case PartKind::kPartial:
        status =
            take(view.id, decode_partial(part.bytes, part.version, limits), view.partial, part);
        break;
      case PartKind::kTiles:
        status = take(view.id, decode_tiles(part.bytes, part.version, limits), view.tiles, part);
        break;
      default:
        break;
    }
    if (!status) return base::fail(status.error());
  }
  const geometry::CameraModel& model = view.estimate.model;
  if (view.matte && !view.estimate.lost() &&
      (view.matte->alpha.width() != model.width || view.matte->alpha.height() != model.height)) {
    return base::fail(
        at(view.id, {ErrorKind::kFormat,
                     "matte",
                     fmt::format("{}x{} for a camera of {}x{}", view.matte->alpha.width(),
                                 view.matte->alpha.height(), model.width, model.height),
                     {}}));
  }
  return view;
}

}  // namespace touchline::codec
