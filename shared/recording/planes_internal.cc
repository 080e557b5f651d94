#include "shared/recording/planes_internal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace touchline::recording {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint16_t kMostCode = 1023;

// The deprecated "J" formats are the plain ones in full range.
AVPixelFormat plain_format(int format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    case AV_PIX_FMT_YUVJ440P:
      return AV_PIX_FMT_YUV440P;
    case AV_PIX_FMT_YUVJ411P:
      return AV_PIX_FMT_YUV411P;
    default:
      return static_cast<AVPixelFormat>(format);
  }
}

bool is_rgb(int format) {
  const AVPixFmtDescriptor* descriptor = av_pix_fmt_desc_get(plain_format(format));
  return descriptor && (descriptor->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0;
}

int swscale_matrix(image::Matrix matrix) {
  switch (matrix) {
    case image::Matrix::kBt601:
      return SWS_CS_ITU601;
    case image::Matrix::kBt2020:
      return SWS_CS_BT2020;
    case image::Matrix::kBt709:
      break;
  }
  return SWS_CS_ITU709;
}

void copy_plane(const std::uint8_t* source, int stride, image::Image<std::uint16_t>& plane) {
  for (int y = 0; y < plane.height(); ++y) {
    const auto* row = reinterpret_cast<const std::uint16_t*>(source + std::ptrdiff_t{stride} * y);
    std::transform(row, row + plane.width(), plane.row(y),
                   [](std::uint16_t code) { return std::min(code, kMostCode); });
  }
}

// Full-range samples, scaled to 10 bits by a shift from `depth` bits, become limited.
void limit_range(image::Image<std::uint16_t>& plane, int depth, bool chroma) {
  const double most = static_cast<double>((1 << depth) - 1) * std::pow(2.0, 10 - depth);
  std::array<std::uint16_t, kMostCode + 1> limited{};
  for (int code = 0; code <= kMostCode; ++code) {
    const double value = chroma ? 512 + 896 * (code - 512) / most : 64 + 876 * code / most;
    limited[static_cast<std::size_t>(code)] =
        static_cast<std::uint16_t>(std::lround(std::clamp(value, 4.0, 1019.0)));
  }
  for (int y = 0; y < plane.height(); ++y) {
    std::transform(plane.row(y), plane.row(y) + plane.width(), plane.row(y),
                   [&](std::uint16_t code) { return limited[code]; });
  }
}

base::Result<Scaler> make_scaler(const AVFrame& picture, image::Matrix matrix) {
  Scaler scaler(sws_alloc_context());
  const AVPixelFormat format = plain_format(picture.format);
  const AVPixFmtDescriptor* descriptor = av_pix_fmt_desc_get(format);
  if (!scaler || !descriptor || sws_isSupportedInput(format) == 0) {
    return base::fail(base::ErrorKind::kUnsupported, "pixel format",
                      std::string(descriptor ? descriptor->name : "unknown") + " is not read",
                      "store the video as 4:2:2 or 4:2:0 Y'CbCr");
  }
  const auto set = [&](const char* name, std::int64_t value) {
    av_opt_set_int(scaler.get(), name, value, 0);
  };
  set("srcw", picture.width);
  set("srch", picture.height);
  set("src_format", format);
  set("dstw", picture.width);
  set("dsth", picture.height);
  set("dst_format", AV_PIX_FMT_YUV422P10LE);
  // Y'CbCr keeps its range here: swscale's own conversion is off by two codes.
  const int source_range = is_rgb(picture.format) ? 1 : 0;
  set("src_range", source_range);
  set("dst_range", 0);
  set("sws_flags", SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_FULL_CHR_H_INT);
  // Chroma positions in 1/256 luma samples; MPEG's own where the stream states none.
  if (descriptor->log2_chroma_w > 0) {
    set("src_h_chr_pos", picture.chroma_location == AVCHROMA_LOC_CENTER ? 128 : 0);
  }
  if (descriptor->log2_chroma_h > 0) {
    set("src_v_chr_pos", picture.chroma_location == AVCHROMA_LOC_TOPLEFT ? 0 : 128);
  }
  set("dst_h_chr_pos", 0);
  if (const int code = sws_init_context(scaler.get(), nullptr, nullptr); code < 0) {
    return base::fail(base::ErrorKind::kUnsupported, "pixel format",
                      std::string(descriptor->name) + ": " + ffmpeg_text(code));
  }
  const int* table = sws_getCoefficients(swscale_matrix(matrix));
  sws_setColorspaceDetails(scaler.get(), table, source_range, table, 0, 0, 1 << 16, 1 << 16);
  return scaler;
}

}  // namespace

image::Colour colour_of(const AVFrame& picture) {
  image::Colour colour;
  switch (picture.colorspace) {
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
    case AVCOL_SPC_FCC:
      colour.matrix = image::Matrix::kBt601;
      break;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      colour.matrix = image::Matrix::kBt2020;
      break;
    default:
      colour.matrix = image::Matrix::kBt709;
      break;
  }
  const bool full = picture.color_range == AVCOL_RANGE_JPEG ||
                    plain_format(picture.format) != static_cast<AVPixelFormat>(picture.format);
  colour.range = full ? image::Range::kFull : image::Range::kLimited;
  return colour;
}

base::Status PlaneConverter::convert(const AVFrame& picture, image::Frame& frame) {
  const image::Colour colour = colour_of(picture);
  const bool full = colour.range == image::Range::kFull;
  frame.format = image::PixelFormat::kYuv422p10;
  frame.colour = {is_rgb(picture.format) ? image::Matrix::kBt709 : colour.matrix,
                  image::Range::kLimited};
  const int chroma_width = AV_CEIL_RSHIFT(picture.width, 1);
  frame.planes[0] = image::Image<std::uint16_t>(picture.width, picture.height);
  frame.planes[1] = image::Image<std::uint16_t>(chroma_width, picture.height);
  frame.planes[2] = image::Image<std::uint16_t>(chroma_width, picture.height);
  if (picture.format == AV_PIX_FMT_YUV422P10LE) {
    for (std::size_t i = 0; i < 3; ++i) {
      copy_plane(picture.data[i], picture.linesize[i], frame.planes[i]);
    }
  } else if (auto status = scale(picture, frame); !status) {
    return status;
  }
  if (full && !is_rgb(picture.format)) {
    const AVPixFmtDescriptor& descriptor = *av_pix_fmt_desc_get(plain_format(picture.format));
    for (std::size_t i = 0; i < 3; ++i) {
      limit_range(frame.planes[i], descriptor.comp[0].depth, i > 0);
    }
  }
  return {};
}

base::Status PlaneConverter::scale(const AVFrame& picture, image::Frame& frame) {
  if (!scaler_ || width_ != picture.width || height_ != picture.height ||
      format_ != picture.format) {
    auto scaler = make_scaler(picture, frame.colour.matrix);
    if (!scaler) return base::fail(scaler.error());
    scaler_ = std::move(*scaler);
    width_ = picture.width;
    height_ = picture.height;
    format_ = picture.format;
  }
  // swscale wants aligned rows with room at their ends.
  AvFrame wide(av_frame_alloc());
  wide->format = AV_PIX_FMT_YUV422P10LE;
  wide->width = picture.width;
  wide->height = picture.height;
  if (const int code = av_frame_get_buffer(wide.get(), 0); code < 0) {
    return base::fail(base::ErrorKind::kLimit, "picture", ffmpeg_text(code));
  }
  const int rows = sws_scale(scaler_.get(), picture.data, picture.linesize, 0, picture.height,
                             wide->data, wide->linesize);
  if (rows != picture.height) {
    return base::fail(base::ErrorKind::kUnsupported, "pixel format",
                      "the picture cannot be converted");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    copy_plane(wide->data[i], wide->linesize[i], frame.planes[i]);
  }
  return {};
}

}  // namespace touchline::recording
