// Segment files: a header, then records, each with its length and checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "shared/base/result.h"

namespace touchline::session {

inline constexpr std::uint16_t kSegmentVersion = 1;
inline constexpr std::size_t kSegmentHeaderBytes = 16;
inline constexpr std::size_t kRecordHeaderBytes = 16;
inline constexpr std::size_t kMaxPayloadBytes = std::size_t{256} << 20;

enum class RecordKind : std::uint16_t { kView = 1, kPlateTile = 2 };

// Where a record lies; `length` is the payload's.
struct RecordPlace {
  std::uint32_t segment = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t end() const { return offset + kRecordHeaderBytes + length; }
};

std::string segment_name(std::uint32_t number);  // "segment-000007.bin"

class SegmentWriter {
 public:
  SegmentWriter(std::filesystem::path folder, std::uint64_t roll_bytes)
      : folder_(std::move(folder)), roll_bytes_(roll_bytes) {}
  ~SegmentWriter();
  SegmentWriter(const SegmentWriter&) = delete;
  SegmentWriter& operator=(const SegmentWriter&) = delete;

  // Writes one record with write(2), so that it outlives the process. After a failure the part that
  // was written is cut off again.
  base::Result<RecordPlace> append(RecordKind kind, std::span<const std::uint8_t> payload);
  // Takes the last record back; after a failure to index it.
  void drop(const RecordPlace& place);
  // To the disk, and closed.
  base::Status finish();
  std::uint64_t bytes_written() const { return total_; }

 private:
  base::Status open_next();
  base::Status write(std::span<const std::uint8_t> bytes, const char* what);
  std::filesystem::path file() const { return folder_ / segment_name(number_); }

  std::filesystem::path folder_;
  std::uint64_t roll_bytes_;
  int descriptor_ = -1;
  std::uint32_t number_ = 0;  // of the open segment, or of the next one
  std::uint64_t size_ = 0;
  std::uint64_t total_ = 0;
};

// The payload of a record, its checksum verified; safe from several threads at once. kNotFound:
// no such segment; kUnsupported: another version; kTruncated, kFormat: damage.
base::Result<std::vector<std::uint8_t>> read_record(const std::filesystem::path& folder,
                                                    const RecordPlace& place, RecordKind kind);

}  // namespace touchline::session
