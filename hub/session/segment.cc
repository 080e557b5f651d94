#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "hub/session/segment_internal.h"
#include "shared/codec/byte_stream.h"

// Segment header: "TLSG", version (16 bits), 0 (16), number (32), 0 (32). Record header: "TLRC",
// kind (16), 0 (16), payload's length (32), CRC-32 of the header so far and the payload (32).

namespace touchline::session {
namespace {

using base::ErrorKind;
using codec::ByteReader;
using codec::ByteWriter;

constexpr std::uint32_t kSegmentMagic = 0x47534c54;
constexpr std::uint32_t kRecordMagic = 0x43524c54;

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

base::Error io_error(const std::filesystem::path& file, std::string_view doing, int code) {
  const char* cure = "check the disk and the folder's permissions";
  if (code == ENOSPC || code == EDQUOT || code == EFBIG) {
    cure = "free space on that disk or put the session elsewhere; what was written stays readable";
  }
  return {ErrorKind::kIo, file.string(), fmt::format("{}: {}", doing, std::strerror(code)), cure};
}

ByteWriter record_header(RecordKind kind, std::size_t length) {
  ByteWriter out;
  out.put(kRecordMagic);
  out.put(static_cast<std::uint16_t>(kind));
  out.put(std::uint16_t{0});
  out.put(static_cast<std::uint32_t>(length));
  return out;
}

std::uint32_t checksum(const ByteWriter& header, std::span<const std::uint8_t> payload) {
  uLong crc = crc32_z(0, header.view().data(), header.size());
  crc = crc32_z(crc, payload.data(), payload.size());
  return static_cast<std::uint32_t>(crc);
}

// All of `out` from `offset`; false at the end of the file or on an error.
bool read_at(int descriptor, std::span<std::uint8_t> out, std::uint64_t offset) {
  while (!out.empty()) {
    const ssize_t n = ::pread(descriptor, out.data(), out.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return true;
}

}  // namespace

std::string segment_name(std::uint32_t number) { return fmt::format("segment-{:06}.bin", number); }

SegmentWriter::~SegmentWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

base::Status SegmentWriter::write(std::span<const std::uint8_t> bytes, const char* what) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return base::fail(io_error(file(), fmt::format("writing {}", what), errno));
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

base::Status SegmentWriter::open_next() {
  descriptor_ = ::open(file().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) return base::fail(io_error(file(), "creating", errno));
  ByteWriter header;
  header.put(kSegmentMagic);
  header.put(kSegmentVersion);
  header.put(std::uint16_t{0});
  header.put(number_);
  header.put(std::uint32_t{0});
  if (base::Status status = write(header.view(), "a segment's header"); !status) {
    ::close(descriptor_);
    descriptor_ = -1;
    return status;
  }
  size_ = kSegmentHeaderBytes;
  return {};
}

base::Result<RecordPlace> SegmentWriter::append(RecordKind kind,
                                                std::span<const std::uint8_t> payload) {
  if (payload.size() > kMaxPayloadBytes) {
    return base::fail(
        ErrorKind::kLimit, file().string(),
        fmt::format("a payload of {} bytes, at most {} allowed", payload.size(), kMaxPayloadBytes));
  }
  if (descriptor_ >= 0 && size_ >= roll_bytes_) {
    if (base::Status status = finish(); !status) return base::fail(status.error());
    ++number_;
  }
  if (descriptor_ < 0) {
    if (base::Status status = open_next(); !status) return base::fail(status.error());
  }
  ByteWriter header = record_header(kind, payload.size());
  header.put(checksum(header, payload));
  const RecordPlace place{number_, size_, payload.size()};
  base::Status status = write(header.view(), "a record's header");
  if (status) status = write(payload, "a payload");
  if (!status) {
    drop(place);
    return base::fail(status.error());
  }
  size_ = place.end();
  total_ += kRecordHeaderBytes + payload.size();
  return place;
}

void SegmentWriter::drop(const RecordPlace& place) {
  // Cutting off can only fail where the disk is failing; the index then still does not know of it.
  if (::ftruncate(descriptor_, static_cast<off_t>(place.offset)) == 0 &&
      ::lseek(descriptor_, static_cast<off_t>(place.offset), SEEK_SET) >= 0) {
    size_ = place.offset;
  } else {
    ::close(descriptor_);
    descriptor_ = -1;
    ++number_;
  }
}

base::Status SegmentWriter::finish() {
  if (descriptor_ < 0) return {};
  const int synced = ::fdatasync(descriptor_);
  const int code = errno;
  ::close(descriptor_);
  descriptor_ = -1;
  if (synced != 0) return base::fail(io_error(file(), "bringing to the disk", code));
  return {};
}

base::Result<std::vector<std::uint8_t>> read_record(const std::filesystem::path& folder,
                                                    const RecordPlace& place, RecordKind kind) {
  const std::filesystem::path file = folder / segment_name(place.segment);
  const std::string where = fmt::format("{} at {}", file.string(), place.offset);
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.get() < 0) {
    if (errno == ENOENT) return base::fail(ErrorKind::kNotFound, where, "no such segment");
    return base::fail(io_error(file, "opening", errno));
  }
  std::array<std::uint8_t, kSegmentHeaderBytes> start{};
  if (!read_at(descriptor.get(), start, 0)) {
    return base::fail(ErrorKind::kTruncated, where, "the segment ends inside its header");
  }
  ByteReader segment(start);
  if (segment.get<std::uint32_t>() != kSegmentMagic) {
    return base::fail(ErrorKind::kFormat, where, "not a segment");
  }
  if (const auto version = segment.get<std::uint16_t>(); version != kSegmentVersion) {
    return base::fail(
        ErrorKind::kUnsupported, where,
        fmt::format("segment format {}, this program reads {}", version, kSegmentVersion),
        "use the version of Touchline that wrote it");
  }
  if (place.length > kMaxPayloadBytes || place.offset > std::uint64_t{1} << 60) {
    return base::fail(ErrorKind::kLimit, where, "a record larger than allowed");
  }
  std::array<std::uint8_t, kRecordHeaderBytes> head{};
  const off_t end = ::lseek(descriptor.get(), 0, SEEK_END);
  if (end < 0 || place.end() > static_cast<std::uint64_t>(end) ||
      !read_at(descriptor.get(), head, place.offset)) {
    return base::fail(ErrorKind::kTruncated, where, "the segment ends before the record does");
  }
  const ByteWriter wanted = record_header(kind, place.length);
  if (std::memcmp(wanted.view().data(), head.data(), wanted.size()) != 0) {
    return base::fail(ErrorKind::kFormat, where, "not the record that the index names");
  }
  std::vector<std::uint8_t> payload(place.length);
  if (!read_at(descriptor.get(), payload, place.offset + kRecordHeaderBytes)) {
    return base::fail(ErrorKind::kTruncated, where, "the segment ends before the record does");
  }
  std::uint32_t stored = 0;
  std::memcpy(&stored, head.data() + wanted.size(), sizeof stored);
  if (checksum(wanted, payload) != stored) {
    return base::fail(ErrorKind::kFormat, where, "checksum does not match: the bytes changed");
  }
  return payload;
}

}  // namespace touchline::session
