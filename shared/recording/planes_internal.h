// A picture of libavcodec as planes of ours.
#pragma once

#include "shared/base/result.h"
#include "shared/image/frame.h"
#include "shared/recording/ffmpeg_internal.h"

namespace touchline::recording {

// Keeps its scaler from picture to picture.
class PlaneConverter {
 public:
  // Fills format, colour and planes of `frame`: kYuv422p10, limited range, chroma co-sited on even
  // luma samples.
  base::Status convert(const AVFrame& picture, image::Frame& frame);

 private:
  // Planes at 10 bits in 4:2:2; R'G'B' comes out limited, Y'CbCr in its own range.
  base::Status scale(const AVFrame& picture, image::Frame& frame);

  Scaler scaler_;
  int width_ = 0;
  int height_ = 0;
  int format_ = -1;
};

// What the picture says about its colour; BT.709 limited where it says nothing.
image::Colour colour_of(const AVFrame& picture);

}  // namespace touchline::recording
