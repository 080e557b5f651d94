// Bytes and time of what is sent. Every codec is shown to give back what it took before it is
// timed. Mattes: the peers code alpha, unknown and occluders as one picture of three heights,
// without loss. Partials: Draco's own defaults on a cloud of the same vertices, which keeps neither
// rings nor features. Tiles: JPEG of the same quality a tile by libjpeg-turbo (OpenCV, 4:2:0,
// complete files), PNG and WebP.
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "hub/hull/carve.h"
#include "hub/output/ply.h"
#include "shared/codec/matte_codec.h"
#include "shared/codec/partial_codec.h"
#include "shared/codec/plate_codec.h"
#include "shared/codec/tile_codec.h"
#include "shared/codec/view_codec.h"
#include "tests/bench/bench.h"
#include "tests/bench/ffv1_peer.h"
#include "tests/bench/input.h"
#include "tests/support/folders.h"

namespace touchline::bench {
namespace {

using Bytes = std::vector<std::uint8_t>;

// The fullest matte of the instant: the one that matters for the worst case.
const codec::CameraView& view(Size size) {
  const auto& views = instant(size);
  const auto foreground = [](const codec::CameraView& v) {
    return std::count_if(v.matte->alpha.data(), v.matte->alpha.data() + v.matte->alpha.size(),
                         [](std::uint8_t a) { return a >= 128; });
  };
  static std::map<Size, std::size_t> fullest;
  const auto found = fullest.find(size);
  if (found != fullest.end()) return views[found->second];
  std::size_t best = 0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    if (foreground(views[i]) > foreground(views[best])) best = i;
  }
  return views[fullest[size] = best];
}

// A coder of mattes: gives back what it took, exactly.
struct MatteCoder {
  std::function<Bytes(const image::Matte&)> encode;
  std::function<bool(const Bytes&, const image::Matte&)> decodes_to;
};

image::Image<std::uint8_t> stacked(const image::Matte& matte) {
  const int h = matte.alpha.height();
  image::Image<std::uint8_t> out(matte.alpha.width(), 3 * h);
  std::copy_n(matte.alpha.data(), matte.alpha.size(), out.row(0));
  std::copy_n(matte.unknown.data(), matte.alpha.size(), out.row(h));
  std::copy_n(matte.occluders.data(), matte.alpha.size(), out.row(2 * h));
  return out;
}

MatteCoder our_matte() {
  return {[](const image::Matte& m) { return *codec::encode_matte(m); },
          [](const Bytes& b, const image::Matte& m) {
            const auto back = codec::decode_matte(b, codec::kMatteVersion, {});
            return back && *back == m;
          }};
}

MatteCoder zstd_matte(int level) {
  return {[level](const image::Matte& m) {
            const auto all = stacked(m);
            Bytes out(ZSTD_compressBound(all.size()));
            out.resize(ZSTD_compress(out.data(), out.size(), all.data(), all.size(), level));
            return out;
          },
          [](const Bytes& b, const image::Matte& m) {
            image::Image<std::uint8_t> back(m.alpha.width(), 3 * m.alpha.height());
            ZSTD_decompress(back.data(), back.size(), b.data(), b.size());
            return std::equal(m.alpha.data(), m.alpha.data() + m.alpha.size(), back.data());
          }};
}

MatteCoder png_matte(int level) {
  return {[level](const image::Matte& m) {
            auto all = stacked(m);
            Bytes out;
            cv::imencode(".png", cv::Mat(all.height(), all.width(), CV_8UC1, all.data()), out,
                         {cv::IMWRITE_PNG_COMPRESSION, level});
            return out;
          },
          [](const Bytes& b, const image::Matte& m) {
            const cv::Mat back = cv::imdecode(b, cv::IMREAD_GRAYSCALE);
            return std::equal(m.alpha.data(), m.alpha.data() + m.alpha.size(), back.data);
          }};
}

MatteCoder ffv1_matte(Size size) {
  const image::Matte& m = *view(size).matte;
  auto coder = std::make_shared<Ffv1>(m.alpha.width(), 3 * m.alpha.height());
  return {[coder](const image::Matte& matte) { return coder->encode(stacked(matte)); },
          [coder](const Bytes& b, const image::Matte& matte) {
            const auto back = coder->decode(b);
            return back.size() == 3 * matte.alpha.size() &&
                   std::equal(matte.alpha.data(), matte.alpha.data() + matte.alpha.size(),
                              back.data());
          }};
}

using MakeMatteCoder = std::function<MatteCoder(Size)>;

void encode_mattes(benchmark::State& state, Size size, const MakeMatteCoder& make) {
  const MatteCoder coder = make(size);
  double bytes = 0;
  std::size_t worst = 0;
  for (const codec::CameraView& v : instant(size)) {
    const Bytes encoded = coder.encode(*v.matte);
    if (encoded.empty() || !coder.decodes_to(encoded, *v.matte)) {
      return state.SkipWithError("what comes back is not what went in");
    }
    bytes += static_cast<double>(encoded.size()) / static_cast<double>(instant(size).size());
    worst = std::max(worst, encoded.size());
  }
  state.counters["bytes"] = bytes;
  state.counters["worst_bytes"] = static_cast<double>(worst);
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(coder.encode(*instant(size)[next].matte));
    next = (next + 1) % instant(size).size();
  }
}

void decode_mattes(benchmark::State& state, Size size, const MakeMatteCoder& make) {
  const MatteCoder coder = make(size);
  std::vector<Bytes> encoded;
  for (const codec::CameraView& v : instant(size)) encoded.push_back(coder.encode(*v.matte));
  std::size_t next = 0;
  for (auto _ : state) {
    if (!coder.decodes_to(encoded[next], *instant(size)[next].matte)) {
      return state.SkipWithError("what comes back is not what went in");
    }
    next = (next + 1) % encoded.size();
  }
}

// Partials.

void encode_partials(benchmark::State& state, Size size) {
  const geometry::Partial& partial = *view(size).partial;
  const auto encoded = codec::encode_partial(partial);
  if (!encoded) return state.SkipWithError(base::to_string(encoded.error()).c_str());
  const auto back = codec::decode_partial(*encoded, codec::kPartialVersion, {});
  if (!back || back->polygons.size() != partial.polygons.size() ||
      *codec::encode_partial(*back) != *encoded) {
    return state.SkipWithError("what comes back is not what went in");
  }
  state.counters["bytes"] = static_cast<double>(encoded->size());
  for (auto _ : state) benchmark::DoNotOptimize(codec::encode_partial(partial));
}

void decode_partials(benchmark::State& state, Size size) {
  const Bytes encoded = *codec::encode_partial(*view(size).partial);
  for (auto _ : state) {
    benchmark::DoNotOptimize(codec::decode_partial(encoded, codec::kPartialVersion, {}));
  }
}

std::unique_ptr<draco::PointCloud> cloud(Size size) {
  draco::PointCloudBuilder builder;
  std::size_t count = 0;
  for (const auto& polygon : view(size).partial->polygons) count += polygon.ring.size();
  builder.Start(static_cast<std::uint32_t>(count));
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  std::uint32_t i = 0;
  for (const auto& polygon : view(size).partial->polygons) {
    for (const Eigen::Vector2f& p : polygon.ring) {
      const std::array<float, 3> value = {p.x(), p.y(), polygon.near_m};
      builder.SetAttributeValueForPoint(position, draco::PointIndex(i++), value.data());
    }
  }
  return builder.Finalize(false);
}

// What draco_encoder does unless told otherwise: 11 bits a position, compression level 7.
draco::Encoder draco_defaults() {
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 11);
  encoder.SetSpeedOptions(3, 3);
  return encoder;
}

void encode_cloud(benchmark::State& state, Size size) {
  const auto points = cloud(size);
  draco::Encoder encoder = draco_defaults();
  draco::EncoderBuffer buffer;
  for (auto _ : state) {
    buffer.Clear();
    if (!encoder.EncodePointCloudToBuffer(*points, &buffer).ok()) {
      return state.SkipWithError("not encoded");
    }
  }
  state.counters["bytes"] = static_cast<double>(buffer.size());
}

void decode_cloud(benchmark::State& state, Size size) {
  draco::EncoderBuffer buffer;
  draco_defaults().EncodePointCloudToBuffer(*cloud(size), &buffer);
  for (auto _ : state) {
    draco::DecoderBuffer in;
    in.Init(buffer.data(), buffer.size());
    draco::Decoder decoder;
    if (!decoder.DecodePointCloudFromBuffer(&in).ok()) return state.SkipWithError("not decoded");
  }
}

// Meshes: what the hub writes for others, against Draco.

const geometry::Mesh& surface() {
  static const geometry::Mesh joined = [] {
    geometry::Mesh out;
    const auto carved = hull::carve(instant(Size::k1080), the_pitch(), {});
    for (const scene::HullGroup& group : carved.hull.groups) {
      const auto first = static_cast<std::uint32_t>(out.vertices.size());
      out.vertices.insert(out.vertices.end(), group.surface.vertices.begin(),
                          group.surface.vertices.end());
      for (const auto& t : group.surface.triangles) {
        out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
    }
    return out;
  }();
  return joined;
}

void write_mesh(benchmark::State& state) {
  const support::TempFolder folder;
  const auto path = folder / "mesh.ply";
  must(output::write_ply(path, surface()));
  const auto back = output::read_ply(path);
  if (!back || back->triangles != surface().triangles) {
    return state.SkipWithError("what comes back is not what went in");
  }
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(path));
  state.counters["triangles"] = static_cast<double>(surface().triangles.size());
  for (auto _ : state) must(output::write_ply(path, surface()));
}

void draco_mesh(benchmark::State& state) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(surface().triangles.size()));
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  std::uint32_t face = 0;
  for (const auto& t : surface().triangles) {
    builder.SetAttributeValuesForFace(
        position, draco::FaceIndex(face++), surface().vertices[t[0]].data(),
        surface().vertices[t[1]].data(), surface().vertices[t[2]].data());
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder = draco_defaults();
  draco::EncoderBuffer buffer;
  for (auto _ : state) {
    buffer.Clear();
    if (!encoder.EncodeMeshToBuffer(*mesh, &buffer).ok()) return state.SkipWithError("not encoded");
  }
  state.counters["bytes"] = static_cast<double>(buffer.size());
}

// Tiles.

double mean_error(const std::vector<codec::TextureTile>& a, const std::vector<cv::Mat>& b) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(a[i].pixels.data());
    for (std::size_t k = 0; k < 3 * a[i].pixels.size(); ++k) {
      const double d = static_cast<double>(bytes[k]) - b[i].data[k];
      sum += d * d;
    }
    count += 3.0 * static_cast<double>(a[i].pixels.size());
  }
  return count > 0 ? sum / count : 0;
}

double psnr(double squared) { return squared > 0 ? 10 * std::log10(255 * 255 / squared) : 99; }

void encode_tiles(benchmark::State& state, Size size) {
  const auto& tiles = *view(size).tiles;
  codec::TileOptions options;
  options.max_bytes = 0;
  const auto encoded = codec::encode_tiles(tiles, options);
  if (!encoded) return state.SkipWithError(base::to_string(encoded.error()).c_str());
  auto back = codec::decode_tiles(*encoded, codec::kTilesVersion, {});
  if (!back || back->size() != tiles.size()) return state.SkipWithError("not decoded");
  std::vector<cv::Mat> pictures;
  for (codec::TextureTile& tile : *back) {
    pictures.emplace_back(tile.pixels.height(), tile.pixels.width(), CV_8UC3, tile.pixels.data());
  }
  state.counters["bytes"] = static_cast<double>(encoded->size());
  state.counters["psnr_db"] = psnr(mean_error(tiles, pictures));
  for (auto _ : state) benchmark::DoNotOptimize(codec::encode_tiles(tiles, options));
}

void decode_tiles(benchmark::State& state, Size size) {
  const Bytes encoded = *codec::encode_tiles(*view(size).tiles, {});
  for (auto _ : state) {
    benchmark::DoNotOptimize(codec::decode_tiles(encoded, codec::kTilesVersion, {}));
  }
}

struct FileKind {
  std::string extension;
  std::vector<int> parameters;
};

// In OpenCV's order of channels; made once.
const std::vector<cv::Mat>& bgr_tiles(Size size) {
  static std::map<Size, std::vector<cv::Mat>> cache;
  std::vector<cv::Mat>& tiles = cache[size];
  if (!tiles.empty()) return tiles;
  for (const codec::TextureTile& tile : *view(size).tiles) {
    const cv::Mat rgb(tile.pixels.height(), tile.pixels.width(), CV_8UC3,
                      const_cast<image::Rgb8*>(tile.pixels.data()));
    cv::cvtColor(rgb, tiles.emplace_back(), cv::COLOR_RGB2BGR);
  }
  return tiles;
}

std::vector<Bytes> files_of(Size size, const FileKind& kind) {
  std::vector<Bytes> out;
  for (const cv::Mat& tile : bgr_tiles(size)) {
    cv::imencode(kind.extension, tile, out.emplace_back(), kind.parameters);
  }
  return out;
}

void encode_files(benchmark::State& state, Size size, const FileKind& kind) {
  const std::vector<Bytes> files = files_of(size, kind);
  double bytes = 0;
  std::vector<cv::Mat> pictures;
  for (const Bytes& file : files) {
    bytes += static_cast<double>(file.size());
    pictures.push_back(cv::imdecode(file, cv::IMREAD_COLOR));
    cv::cvtColor(pictures.back(), pictures.back(), cv::COLOR_BGR2RGB);
  }
  state.counters["bytes"] = bytes;
  state.counters["psnr_db"] = psnr(mean_error(*view(size).tiles, pictures));
  for (auto _ : state) benchmark::DoNotOptimize(files_of(size, kind));
}

void decode_files(benchmark::State& state, Size size, const FileKind& kind) {
  const std::vector<Bytes> files = files_of(size, kind);
  for (auto _ : state) {
    for (const Bytes& file : files) {
      benchmark::DoNotOptimize(cv::imdecode(file, cv::IMREAD_COLOR).data);
    }
  }
}

// Plate tiles and whole views.

const image::PlateTile& plate_tile() {
  // The one that was seen most.
  const auto& tiles = plate(recording::Role::kFixed, Size::k1080).tiles;
  const auto seen = [](const image::PlateTile& t) {
    return std::count_if(t.count.data(), t.count.data() + t.count.size(),
                         [](std::uint8_t c) { return c > 0; });
  };
  return *std::max_element(tiles.begin(), tiles.end(), [&](const auto& a, const auto& b) {
            return seen(*a.second) < seen(*b.second);
          })->second;
}

void encode_plate_tile(benchmark::State& state) {
  const auto encoded = codec::encode_plate_tile(plate_tile(), {}, {});
  if (!encoded) return state.SkipWithError(base::to_string(encoded.error()).c_str());
  state.counters["bytes"] = static_cast<double>(encoded->size());
  for (auto _ : state) benchmark::DoNotOptimize(codec::encode_plate_tile(plate_tile(), {}, {}));
}

void png_plate_tile(benchmark::State& state) {
  const image::PlateTile& tile = plate_tile();
  std::vector<cv::Mat> planes;
  for (const auto& plane : tile.mean) {
    planes.emplace_back(plane.height(), plane.width(), CV_16UC1,
                        const_cast<std::uint16_t*>(plane.data()));
  }
  cv::Mat all;
  cv::merge(planes, all);
  all.convertTo(all, CV_8U, 1 / 64.0);
  Bytes bytes;
  for (auto _ : state) cv::imencode(".png", all, bytes);
  state.counters["bytes"] = static_cast<double>(bytes.size());
}

void encode_view(benchmark::State& state, Size size) {
  const codec::CameraView& in = view(size);
  std::size_t bytes = 0;
  const auto encoded = codec::encode(in);
  if (!encoded) return state.SkipWithError(base::to_string(encoded.error()).c_str());
  for (const codec::EncodedPart& part : encoded->parts) bytes += part.bytes.size();
  const auto back = codec::decode(*encoded);
  if (!back || *back->matte != *in.matte) return state.SkipWithError("the matte changed");
  state.counters["bytes"] = static_cast<double>(bytes);
  state.counters["mbit_s_at_50"] = static_cast<double>(bytes) * 8 * 50 / 1e6;
  for (auto _ : state) benchmark::DoNotOptimize(codec::encode(in));
}

void decode_view(benchmark::State& state, Size size) {
  const auto encoded = must(codec::encode(view(size)));
  for (auto _ : state) benchmark::DoNotOptimize(codec::decode(encoded));
}

void add_all() {
  const std::vector<std::pair<std::string, MakeMatteCoder>> coders = {
      {kOurs, [](Size) { return our_matte(); }},
      {"zstd -1", [](Size) { return zstd_matte(1); }},
      {"zstd -9", [](Size) { return zstd_matte(9); }},
      {"PNG level 1", [](Size) { return png_matte(1); }},
      {"PNG level 6", [](Size) { return png_matte(6); }},
      {"FFV1", ffv1_matte}};
  const std::vector<std::pair<std::string, FileKind>> kinds = {
      {"libjpeg-turbo quality 92", {".jpg", {cv::IMWRITE_JPEG_QUALITY, 92}}},
      {"PNG level 1", {".png", {cv::IMWRITE_PNG_COMPRESSION, 1}}},
      {"WebP quality 92", {".webp", {cv::IMWRITE_WEBP_QUALITY, 92}}}};
  for (const Size size : kSizes) {
    const std::string where = name(size);
    for (const auto& coder : coders) {
      const auto& make = coder.second;
      add("matte encode", coder.first, where,
          [=](auto& state) { encode_mattes(state, size, make); });
      add("matte decode", coder.first, where,
          [=](auto& state) { decode_mattes(state, size, make); });
    }
    add("partial encode", kOurs, where, [=](auto& state) { encode_partials(state, size); });
    add("partial encode", "Draco default cloud", where,
        [=](auto& state) { encode_cloud(state, size); });
    add("partial decode", kOurs, where, [=](auto& state) { decode_partials(state, size); });
    add("partial decode", "Draco default cloud", where,
        [=](auto& state) { decode_cloud(state, size); });
    add("tiles encode", kOurs, where, [=](auto& state) { encode_tiles(state, size); });
    add("tiles decode", kOurs, where, [=](auto& state) { decode_tiles(state, size); });
    for (const auto& file : kinds) {
      const FileKind& kind = file.second;
      add("tiles encode", file.first, where, [=](auto& state) { encode_files(state, size, kind); });
      add("tiles decode", file.first, where, [=](auto& state) { decode_files(state, size, kind); });
    }
    add("view encode", kOurs, where, [=](auto& state) { encode_view(state, size); });
    add("view decode", kOurs, where, [=](auto& state) { decode_view(state, size); });
  }
  add("mesh write", kOurs, "PLY", write_mesh);
  add("mesh write", "Draco default mesh", "PLY", draco_mesh);
  add("plate tile encode", kOurs, "256x256", encode_plate_tile);
  add("plate tile encode", "PNG level 3, 8 bit", "256x256", png_plate_tile);
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
