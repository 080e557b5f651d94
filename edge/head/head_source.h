// Where a unit's encoder counts come from.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "edge/head/head_counts.h"
#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/recording/head_table.h"

namespace touchline::head {

class HeadSource {
 public:
  virtual ~HeadSource() = default;
  // The counts that belong to a frame; nothing where there are none. Never waits.
  virtual std::optional<HeadCounts> at(const base::FrameId& frame,
                                       const base::FrameStamp& stamp) = 0;
};

// The counts of a recording, by frame.
class RecordedHead : public HeadSource {
 public:
  // Rows by rising frame.
  explicit RecordedHead(std::vector<recording::HeadRow> rows) : rows_(std::move(rows)) {}
  std::optional<HeadCounts> at(const base::FrameId& frame, const base::FrameStamp& stamp) override;

 private:
  std::vector<recording::HeadRow> rows_;
};

}  // namespace touchline::head
