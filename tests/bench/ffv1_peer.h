// One grey picture through FFV1, version 3, intra, four slices, one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "shared/image/image.h"

namespace touchline::bench {

class Ffv1 {
 public:
  Ffv1(int width, int height);
  ~Ffv1();
  Ffv1(const Ffv1&) = delete;
  Ffv1& operator=(const Ffv1&) = delete;

  bool ready() const;
  // Empty when it fails.
  std::vector<std::uint8_t> encode(const image::Image<std::uint8_t>& picture);
  image::Image<std::uint8_t> decode(const std::vector<std::uint8_t>& bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::bench
