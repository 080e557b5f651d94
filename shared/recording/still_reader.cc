#include "shared/recording/still_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "shared/recording/csv_internal.h"
#include "shared/recording/ffmpeg_internal.h"
#include "shared/recording/planes_internal.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

namespace touchline::recording {
namespace {

constexpr std::uintmax_t kMostBytes = 256 << 20;
constexpr std::int64_t kMostPixels = 16384 * 8192LL;

// Samples of one plane as floats; position (x, y) in samples, bilinear, held at the edges.
class Plane {
 public:
  Plane(const AVFrame& picture, const AVPixFmtDescriptor& descriptor, int component)
      : chroma_(component > 0),
        shift_x_(chroma_ ? descriptor.log2_chroma_w : 0),
        shift_y_(chroma_ ? descriptor.log2_chroma_h : 0),
        samples_(AV_CEIL_RSHIFT(picture.width, shift_x_),
                 AV_CEIL_RSHIFT(picture.height, shift_y_)) {
    for (int y = 0; y < samples_.height(); ++y) {
      const std::uint8_t* row =
          picture.data[component] + std::ptrdiff_t{picture.linesize[component]} * y;
      std::copy(row, row + samples_.width(), samples_.row(y));
    }
    // JPEG's chroma lies in the middle of the luma samples it stands for.
    const bool centre_x = shift_x_ > 0 && picture.chroma_location != AVCHROMA_LOC_LEFT &&
                          picture.chroma_location != AVCHROMA_LOC_TOPLEFT;
    const bool centre_y = shift_y_ > 0 && picture.chroma_location != AVCHROMA_LOC_TOPLEFT;
    offset_x_ = centre_x ? 0.5F * static_cast<float>((1 << shift_x_) - 1) : 0;
    offset_y_ = centre_y ? 0.5F * static_cast<float>((1 << shift_y_) - 1) : 0;
  }

  float at_luma(int x, int y) const {
    if (shift_x_ == 0 && shift_y_ == 0) return samples_(x, y);
    const float u = (static_cast<float>(x) - offset_x_) / static_cast<float>(1 << shift_x_);
    const float v = (static_cast<float>(y) - offset_y_) / static_cast<float>(1 << shift_y_);
    const float left = std::floor(u);
    const float top = std::floor(v);
    const int x0 = std::clamp(static_cast<int>(left), 0, samples_.width() - 1);
    const int x1 = std::clamp(static_cast<int>(left) + 1, 0, samples_.width() - 1);
    const int y0 = std::clamp(static_cast<int>(top), 0, samples_.height() - 1);
    const int y1 = std::clamp(static_cast<int>(top) + 1, 0, samples_.height() - 1);
    const float a = u - left;
    const float b = v - top;
    const float upper = (1 - a) * samples_(x0, y0) + a * samples_(x1, y0);
    const float lower = (1 - a) * samples_(x0, y1) + a * samples_(x1, y1);
    return (1 - b) * upper + b * lower;
  }

 private:
  bool chroma_;
  int shift_x_;
  int shift_y_;
  float offset_x_ = 0;
  float offset_y_ = 0;
  image::Image<std::uint8_t> samples_;
};

using Triple = std::array<float, 3>;

struct Weights {
  float red;
  float blue;
};

Weights weights_of(image::Matrix matrix) {
  switch (matrix) {
    case image::Matrix::kBt601:
      return {0.299F, 0.114F};
    case image::Matrix::kBt2020:
      return {0.2627F, 0.0593F};
    case image::Matrix::kBt709:
      break;
  }
  return {0.2126F, 0.0722F};
}

// R'G'B' of luma 0..1 and colour differences -0.5..0.5.
Triple rgb_of(const Triple& ypp, Weights w) {
  const float red = ypp[0] + 2 * (1 - w.red) * ypp[2];
  const float blue = ypp[0] + 2 * (1 - w.blue) * ypp[1];
  return {red, (ypp[0] - w.red * red - w.blue * blue) / (1 - w.red - w.blue), blue};
}

// 10-bit limited BT.709 code values, not rounded.
Triple code_of(const Triple& rgb) {
  const Weights w = weights_of(image::Matrix::kBt709);
  const float y = w.red * rgb[0] + (1 - w.red - w.blue) * rgb[1] + w.blue * rgb[2];
  const float pb = (rgb[2] - y) / (2 * (1 - w.blue));
  const float pr = (rgb[0] - y) / (2 * (1 - w.red));
  return {64 + 876 * y, 512 + 896 * pb, 512 + 896 * pr};
}

std::uint16_t code(float value) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(value, 4.0F, 1019.0F)));
}

// Fills a 4:2:2 frame from `triple_at(x, y)`, code values at luma resolution; chroma by (1 2 1)/4.
template <typename TripleAt>
image::Frame frame_from(int width, int height, const TripleAt& triple_at) {
  image::Frame frame;
  const int chroma_width = (width + 1) / 2;
  frame.planes[0] = image::Image<std::uint16_t>(width, height);
  frame.planes[1] = image::Image<std::uint16_t>(chroma_width, height);
  frame.planes[2] = image::Image<std::uint16_t>(chroma_width, height);
  std::vector<Triple> row(static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      row[static_cast<std::size_t>(x)] = triple_at(x, y);
      frame.planes[0](x, y) = code(row[static_cast<std::size_t>(x)][0]);
    }
    for (int c = 0; c < chroma_width; ++c) {
      const auto x = static_cast<std::size_t>(2 * c);
      const Triple& left = row[x > 0 ? x - 1 : 0];
      const Triple& right = row[std::min(x + 1, row.size() - 1)];
      for (std::size_t i = 1; i < 3; ++i) {
        frame.planes[i](c, y) = code((left[i] + 2 * row[x][i] + right[i]) / 4);
      }
    }
  }
  return frame;
}

// Planar 8-bit Y'CbCr or grey, as JPEG decoders give it.
image::Frame from_planar(const AVFrame& picture, const AVPixFmtDescriptor& descriptor) {
  const Plane luma(picture, descriptor, 0);
  const bool full = colour_of(picture).range == image::Range::kFull;
  const auto scaled = [full](float y) { return full ? y / 255 : (y - 16) / 219; };
  if (descriptor.nb_components < 3) {
    return frame_from(picture.width, picture.height, [&](int x, int y) {
      return Triple{64 + 876 * scaled(luma.at_luma(x, y)), 512, 512};
    });
  }
  // JPEG is BT.601 unless it says otherwise.
  const Weights weights =
      weights_of(picture.colorspace == AVCOL_SPC_UNSPECIFIED ? image::Matrix::kBt601
                                                             : colour_of(picture).matrix);
  const Plane cb(picture, descriptor, 1);
  const Plane cr(picture, descriptor, 2);
  const float chroma_scale = full ? 255.0F : 224.0F;
  return frame_from(picture.width, picture.height, [&](int x, int y) {
    return code_of(rgb_of({scaled(luma.at_luma(x, y)), (cb.at_luma(x, y) - 128) / chroma_scale,
                           (cr.at_luma(x, y) - 128) / chroma_scale},
                          weights));
  });
}

// Anything else: R'G'B' or grey of any depth and packing, palettes included; alpha is left out.
base::Result<image::Frame> from_components(const AVFrame& picture,
                                           const AVPixFmtDescriptor& descriptor,
                                           const std::string& file) {
  const bool palette = (descriptor.flags & AV_PIX_FMT_FLAG_PAL) != 0;
  const bool rgb = palette || (descriptor.flags & AV_PIX_FMT_FLAG_RGB) != 0;
  const bool grey = !rgb && descriptor.nb_components <= 2;
  if (!rgb && !grey) {
    return base::fail(base::ErrorKind::kUnsupported, file,
                      std::string(descriptor.name) + " pixels are not read",
                      "store it as an 8-bit JPEG or as an RGB PNG");
  }
  const int depth = palette ? 8 : descriptor.comp[0].depth;
  const auto most = static_cast<float>((1 << depth) - 1);
  std::array<const std::uint8_t*, 4> data{picture.data[0], picture.data[1], picture.data[2],
                                          picture.data[3]};
  std::array<std::vector<std::uint16_t>, 3> line;
  for (auto& component : line) component.resize(static_cast<std::size_t>(picture.width));
  int read_row = -1;
  return frame_from(picture.width, picture.height, [&](int x, int y) {
    if (y != read_row) {
      for (int i = 0; i < 3; ++i) {
        // A palette's bytes are B, G, R, A.
        const int component = grey ? 0 : (palette ? 2 - i : i);
        av_read_image_line2(line[static_cast<std::size_t>(i)].data(), data.data(), picture.linesize,
                            &descriptor, 0, y, component, picture.width, palette ? 1 : 0, 2);
      }
      read_row = y;
    }
    const auto column = static_cast<std::size_t>(x);
    return code_of({static_cast<float>(line[0][column]) / most,
                    static_cast<float>(line[1][column]) / most,
                    static_cast<float>(line[2][column]) / most});
  });
}

bool ends_whole(std::string_view bytes, AVCodecID codec) {
  if (codec == AV_CODEC_ID_PNG) return bytes.rfind("IEND") != std::string_view::npos;
  const auto scan = bytes.rfind("\xFF\xDA");
  return scan != std::string_view::npos && bytes.find("\xFF\xD9", scan) != std::string_view::npos;
}

}  // namespace

base::Result<image::Frame> read_still(const std::filesystem::path& path) {
  const std::string file = path.string();
  const auto bytes = read_file(path, kMostBytes);
  if (!bytes) return base::fail(bytes.error());
  AVCodecID id = AV_CODEC_ID_NONE;
  if (bytes->starts_with("\xFF\xD8\xFF")) id = AV_CODEC_ID_MJPEG;
  if (bytes->starts_with("\x89PNG\r\n\x1A\n")) id = AV_CODEC_ID_PNG;
  const AVCodec* codec = avcodec_find_decoder(id);
  if (!codec) {
    return base::fail(base::ErrorKind::kFormat, file, "is neither a JPEG nor a PNG");
  }
  if (!ends_whole(*bytes, id)) {
    return base::fail(base::ErrorKind::kTruncated, file, "the picture ends too early",
                      "copy it again");
  }
  quiet_ffmpeg();
  CodecContext decoder(avcodec_alloc_context3(codec));
  decoder->thread_count = 1;
  decoder->max_pixels = kMostPixels;
  AvPacket packet(av_packet_alloc());
  AvFrame picture(av_frame_alloc());
  int result = avcodec_open2(decoder.get(), codec, nullptr);
  if (result >= 0) result = av_new_packet(packet.get(), static_cast<int>(bytes->size()));
  if (result >= 0) {
    std::memcpy(packet->data, bytes->data(), bytes->size());
    result = avcodec_send_packet(decoder.get(), packet.get());
  }
  if (result >= 0) result = avcodec_send_packet(decoder.get(), nullptr);
  if (result >= 0) result = avcodec_receive_frame(decoder.get(), picture.get());
  if (result < 0) {
    return base::fail(base::ErrorKind::kFormat, file, "cannot be decoded: " + ffmpeg_text(result));
  }
  const AVPixFmtDescriptor* descriptor =
      av_pix_fmt_desc_get(static_cast<AVPixelFormat>(picture->format));
  if (!descriptor) return base::fail(base::ErrorKind::kUnsupported, file, "has unknown pixels");
  const bool planar = id == AV_CODEC_ID_MJPEG && (descriptor->flags & AV_PIX_FMT_FLAG_RGB) == 0 &&
                      descriptor->comp[0].depth == 8 && descriptor->comp[0].step == 1 &&
                      (descriptor->nb_components == 1 || descriptor->nb_components == 3);
  if (planar) return from_planar(*picture, *descriptor);
  return from_components(*picture, *descriptor, file);
}

}  // namespace touchline::recording
