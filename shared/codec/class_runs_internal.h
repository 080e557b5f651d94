// Rows of runs of pixel classes, each run's start told from the starts in the row above, in the
// manner of ITU-T T.6 widened from two classes to many.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/byte_stream.h"

namespace touchline::codec {

// From `x` on, up to the next start or the row's end, pixels are of class `cls`. A row begins with
// class 0 at its left edge unless a start lies there.
struct RunStart {
  std::int32_t x = 0;
  std::uint8_t cls = 0;
  bool operator==(const RunStart&) const = default;
};

// Rows one after the other. One token a start, plus one that ends each row; what no start of the
// row above foretells goes to `extra`: distance from the last start, and class.
class ClassRunWriter {
 public:
  void add_row(std::span<const RunStart> row);
  std::span<const std::uint8_t> tokens() const { return tokens_; }
  std::span<const std::uint8_t> extra() const { return extra_.view(); }

 private:
  std::vector<RunStart> above_;
  std::vector<std::uint8_t> tokens_;
  ByteWriter extra_;
};

class ClassRunReader {
 public:
  // Starts lie in [0, width), classes below `class_count`.
  ClassRunReader(std::span<const std::uint8_t> tokens, std::span<const std::uint8_t> extra,
                 int width, int class_count)
      : tokens_(tokens), extra_(extra), width_(width), class_count_(class_count) {}

  // The next row, valid until the next call.
  base::Result<std::span<const RunStart>> next_row();
  bool at_end() const { return position_ == tokens_.size() && extra_.remaining() == 0; }

 private:
  std::span<const std::uint8_t> tokens_;
  std::size_t position_ = 0;
  ByteReader extra_;
  int width_;
  int class_count_;
  std::vector<RunStart> above_;
  std::vector<RunStart> row_;
};

}  // namespace touchline::codec
