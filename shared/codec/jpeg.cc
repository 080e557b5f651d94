#include <csetjmp>
#include <cstdio>
#include <cstdlib>

// libjpeg wants cstdio before it.
#include <jpeglib.h>

#include <array>

#include "shared/codec/jpeg_internal.h"

namespace touchline::codec {
namespace {

using base::ErrorKind;

struct ErrorManager {
  jpeg_error_mgr manager{};  // first: libjpeg hands back a pointer to it
  std::jmp_buf jump{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

// No object with a destructor may live between a setjmp below and a call into libjpeg.
[[noreturn]] void on_error(j_common_ptr info) {
  auto* errors = reinterpret_cast<ErrorManager*>(info->err);
  info->err->format_message(info, errors->message.data());
  std::longjmp(errors->jump, 1);
}
void on_message(j_common_ptr info) {
  auto* errors = reinterpret_cast<ErrorManager*>(info->err);
  info->err->format_message(info, errors->message.data());
}

jpeg_error_mgr* prepare(ErrorManager& errors) {
  jpeg_std_error(&errors.manager);
  errors.manager.error_exit = on_error;
  errors.manager.output_message = on_message;
  return &errors.manager;
}

// Memory that libjpeg allocated with malloc.
struct Output {
  unsigned char* data = nullptr;
  unsigned long size = 0;
  ~Output() { std::free(data); }
};

}  // namespace

class JpegWriter::Impl {
 public:
  Impl(JpegColour colour, int quality) {
    info_.err = prepare(errors_);
    made_ = make(colour, quality);
  }
  ~Impl() { jpeg_destroy_compress(&info_); }

  bool write_tables(Output& out) {
    if (!made_) return false;
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_mem_dest(&info_, &out.data, &out.size);
    jpeg_write_tables(&info_);
    return true;
  }
  bool write_image(const JpegPixels& pixels, Output& out) {
    if (!made_) return false;
    if (setjmp(errors_.jump) != 0) {
      jpeg_abort_compress(&info_);
      return false;
    }
    jpeg_mem_dest(&info_, &out.data, &out.size);
    info_.image_width = static_cast<JDIMENSION>(pixels.width);
    info_.image_height = static_cast<JDIMENSION>(pixels.height);
    jpeg_start_compress(&info_, FALSE);
    while (info_.next_scanline < info_.image_height) {
      // libjpeg's rows are not const, and it does not write to them.
      JSAMPROW row = const_cast<JSAMPROW>(pixels.data +
                                          std::size_t{info_.next_scanline} * info_.image_width * 3);
      jpeg_write_scanlines(&info_, &row, 1);
    }
    jpeg_finish_compress(&info_);
    return true;
  }
  const char* message() const { return errors_.message.data(); }

 private:
  bool make(JpegColour colour, int quality) {
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_create_compress(&info_);
    info_.image_width = 8;
    info_.image_height = 8;
    info_.input_components = 3;
    info_.in_color_space = colour == JpegColour::kYcbcr444 ? JCS_YCbCr : JCS_RGB;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    info_.write_JFIF_header = FALSE;
    info_.comp_info[0].h_samp_factor = colour == JpegColour::kRgb422 ? 2 : 1;
    info_.comp_info[0].v_samp_factor = 1;
    return true;
  }

  jpeg_compress_struct info_{};
  ErrorManager errors_;
  bool made_ = false;
};

JpegWriter::JpegWriter(JpegColour colour, int quality)
    : impl_(std::make_unique<Impl>(colour, quality)) {}
JpegWriter::~JpegWriter() = default;

base::Result<std::vector<std::uint8_t>> JpegWriter::tables() {
  Output out;
  if (!impl_->write_tables(out)) return base::fail(ErrorKind::kInternal, "jpeg", impl_->message());
  return std::vector<std::uint8_t>(out.data, out.data + out.size);
}

base::Result<std::vector<std::uint8_t>> JpegWriter::image(const JpegPixels& pixels) {
  Output out;
  if (!impl_->write_image(pixels, out)) {
    return base::fail(ErrorKind::kInternal, "jpeg", impl_->message());
  }
  return std::vector<std::uint8_t>(out.data, out.data + out.size);
}

class JpegReader::Impl {
 public:
  explicit Impl(JpegColour colour) : colour_(colour) {
    info_.err = prepare(errors_);
    made_ = make();
  }
  ~Impl() { jpeg_destroy_decompress(&info_); }

  bool read_tables(std::span<const std::uint8_t> bytes) {
    if (!made_ || bytes.empty()) return false;
    if (setjmp(errors_.jump) != 0) return false;
    errors_.manager.num_warnings = 0;
    jpeg_mem_src(&info_, bytes.data(), bytes.size());
    return jpeg_read_header(&info_, FALSE) == JPEG_HEADER_TABLES_ONLY &&
           errors_.manager.num_warnings == 0;
  }
  bool read_image(std::span<const std::uint8_t> bytes, int width, int height, std::uint8_t* out) {
    if (!made_ || bytes.empty()) return false;
    if (setjmp(errors_.jump) != 0) {
      jpeg_abort_decompress(&info_);
      return false;
    }
    errors_.manager.num_warnings = 0;
    errors_.message = {};
    jpeg_mem_src(&info_, bytes.data(), bytes.size());
    const bool as_announced = jpeg_read_header(&info_, TRUE) == JPEG_HEADER_OK &&
                              info_.image_width == static_cast<JDIMENSION>(width) &&
                              info_.image_height == static_cast<JDIMENSION>(height) &&
                              info_.num_components == 3 && info_.jpeg_color_space == JCS_YCbCr &&
                              !info_.progressive_mode && !info_.arith_code &&
                              !jpeg_has_multiple_scans(&info_);
    if (as_announced) {
      info_.out_color_space = colour_ == JpegColour::kYcbcr444 ? JCS_YCbCr : JCS_RGB;
      jpeg_start_decompress(&info_);
      while (info_.output_scanline < info_.output_height) {
        JSAMPROW row = out + std::size_t{info_.output_scanline} * info_.output_width * 3;
        jpeg_read_scanlines(&info_, &row, 1);
      }
      jpeg_finish_decompress(&info_);
    } else {
      jpeg_abort_decompress(&info_);
    }
    return as_announced && errors_.manager.num_warnings == 0;
  }
  const char* message() const {
    return errors_.message[0] != 0 ? errors_.message.data() : "not the image announced";
  }

 private:
  bool make() {
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_create_decompress(&info_);
    return true;
  }

  JpegColour colour_;
  jpeg_decompress_struct info_{};
  ErrorManager errors_;
  bool made_ = false;
};

JpegReader::JpegReader(JpegColour colour) : impl_(std::make_unique<Impl>(colour)) {}
JpegReader::~JpegReader() = default;

base::Status JpegReader::tables(std::span<const std::uint8_t> bytes) {
  if (!impl_->read_tables(bytes)) return base::fail(ErrorKind::kFormat, "jpeg", impl_->message());
  return {};
}

base::Status JpegReader::image(std::span<const std::uint8_t> bytes, int width, int height,
                               std::uint8_t* out) {
  if (!impl_->read_image(bytes, width, height, out)) {
    return base::fail(ErrorKind::kFormat, "jpeg", impl_->message());
  }
  return {};
}

}  // namespace touchline::codec
