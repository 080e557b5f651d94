#include <array>
#include <cstdlib>
#include <optional>

#include "shared/codec/class_runs_internal.h"

namespace touchline::codec {
namespace {

constexpr int kReach = 12;      // how far a start may lie from the one above that foretells it
constexpr int kCandidates = 4;  // starts above that are tried
constexpr std::uint8_t kEndOfRow = 0;
constexpr std::uint8_t kExtra = 1;
constexpr int kFirstForetold = 2;
static_assert(kFirstForetold + kCandidates * (2 * kReach + 1) <= 256);

// Walks the row above along with the row being coded.
class Foreteller {
 public:
  explicit Foreteller(const std::vector<RunStart>& above) : above_(above) {}

  // The starts above that may foretell the next start after `x` of a run of class `cls`: those from
  // x - 1 on that change to another class.
  std::span<const RunStart* const> after(int x, std::uint8_t cls) {
    while (first_ < above_.size() && above_[first_].x < x) ++first_;
    count_ = 0;
    for (std::size_t i = first_; i < above_.size() && count_ < kCandidates; ++i) {
      if (above_[i].cls != cls) found_[count_++] = &above_[i];
    }
    return std::span(found_).first(count_);
  }

 private:
  const std::vector<RunStart>& above_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::array<const RunStart*, kCandidates> found_{};
};

}  // namespace

void ClassRunWriter::add_row(std::span<const RunStart> row) {
  Foreteller foreteller(above_);
  int x = -1;  // of the last start; the next one lies beyond
  std::uint8_t cls = 0;
  for (const RunStart& start : row) {
    const std::span<const RunStart* const> candidates = foreteller.after(x, cls);
    int best = -1;
    int best_offset = kReach + 1;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      if (candidates[j]->cls != start.cls) continue;
      const int offset = start.x - candidates[j]->x;
      if (std::abs(offset) < std::abs(best_offset)) {
        best = static_cast<int>(j);
        best_offset = offset;
      }
    }
    if (best >= 0 && std::abs(best_offset) <= kReach) {
      tokens_.push_back(static_cast<std::uint8_t>(kFirstForetold + best * (2 * kReach + 1) +
                                                  best_offset + kReach));
    } else {
      tokens_.push_back(kExtra);
      extra_.put_varint(static_cast<std::uint32_t>(start.x - x - 1));
      extra_.put(start.cls);
    }
    x = start.x;
    cls = start.cls;
  }
  tokens_.push_back(kEndOfRow);
  above_.assign(row.begin(), row.end());
}

base::Result<std::span<const RunStart>> ClassRunReader::next_row() {
  const auto damaged = [] {
    return base::fail(base::ErrorKind::kFormat, "matte", "damaged run of classes");
  };
  row_.clear();
  Foreteller foreteller(above_);
  int x = -1;
  std::uint8_t cls = 0;
  for (;;) {
    if (position_ == tokens_.size()) return damaged();
    const std::uint8_t token = tokens_[position_++];
    if (token == kEndOfRow) break;
    RunStart start;
    if (token == kExtra) {
      const std::uint32_t gap = extra_.get_varint();
      start.cls = extra_.get<std::uint8_t>();
      if (!extra_.ok() || gap >= static_cast<std::uint32_t>(width_)) return damaged();
      start.x = x + 1 + static_cast<std::int32_t>(gap);
    } else {
      const int foretold = token - kFirstForetold;
      const auto j = static_cast<std::size_t>(foretold / (2 * kReach + 1));
      const std::span<const RunStart* const> candidates = foreteller.after(x, cls);
      if (j >= candidates.size()) return damaged();
      start.x = candidates[j]->x + foretold % (2 * kReach + 1) - kReach;
      start.cls = candidates[j]->cls;
    }
    if (start.x <= x || start.x >= width_ || start.cls >= class_count_ || start.cls == cls) {
      return damaged();
    }
    row_.push_back(start);
    x = start.x;
    cls = start.cls;
  }
  above_ = row_;
  return std::span<const RunStart>(row_);
}

}  // namespace touchline::codec
