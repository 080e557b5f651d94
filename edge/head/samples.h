// Pairs of a count and a measured value: a bounded number, spread over the counts that were seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace touchline::head {

struct Sample {
  double count = 0;
  double value = 0;
  std::uint64_t age = 0;  // the order they came in
};

class Samples {
 public:
  void add(double count, double value);
  // Forgets all but the newest `n`.
  void keep_newest(std::size_t n);
  void clear();
  std::span<const Sample> all() const { return samples_; }      // by rising count
  const std::deque<Sample>& newest() const { return newest_; }  // the last ten, oldest first
  std::uint64_t taken() const { return taken_; }                // since the last forgetting

 private:
  std::vector<Sample> samples_;
  std::deque<Sample> newest_;
  std::uint64_t next_age_ = 0;
  std::uint64_t taken_ = 0;
};

}  // namespace touchline::head
