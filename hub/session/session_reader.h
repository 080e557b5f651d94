// Reads a session, one that is still being written included: it sees what was there at open().
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hub/scene/frame_set.h"
#include "hub/session/session_info.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::session {

// What open() found that a sound, finished session does not have; none of it stops reading.
struct OpenReport {
  bool finished = false;              // the writer came to its end
  std::uint64_t unindexed_bytes = 0;  // at the ends of segments: an append cut short by a kill
  std::vector<std::string> missing_segments;  // file names of segments with rows that are not there
  std::size_t views = 0;
  std::size_t plate_tiles = 0;
  std::size_t events = 0;
};

struct VerifyOptions {
  bool decode = false;  // also decode every payload
  codec::DecodeLimits limits;
};

// One payload that is not what was written.
struct VerifyFault {
  std::string where;  // segment file and offset; camera and sequence or tile
  std::string what;
};

struct VerifyReport {
  std::size_t payloads = 0;
  std::uint64_t bytes = 0;
  std::vector<VerifyFault>
      faults;  // in the order of the rows; at most 1000, `fault_count` counts all
  std::size_t fault_count = 0;
  OpenReport open;
  bool sound() const { return fault_count == 0 && open.missing_segments.empty(); }
};

// Safe to use from several threads at once. What it returns depends on what the session holds only,
// never on the order in which it arrived.
class SessionReader {
 public:
  // kNotFound: no session there; kUnsupported: another format version, by number; kFormat: an index
  // that is damaged.
  static base::Result<SessionReader> open(const std::filesystem::path& folder,
                                          const codec::DecodeLimits& limits = {});
  SessionReader(SessionReader&&) noexcept;
  SessionReader& operator=(SessionReader&&) noexcept;
  ~SessionReader();

  const SessionInfo& info() const;
  const OpenReport& report() const;

  // Instants at which one camera or more has a view: start + k periods, rising.
  const std::vector<base::MediaTime>& instants() const;
  // k of an instant: the frame's number in exported files.
  std::int64_t frame_number(std::size_t index) const;

  // Every configured camera in its order: the view nearest to the instant within the tolerance, or
  // Absent: kNotYet before its first view, kEnded after its last, kLostInTransit between,
  // kUndecodable when its payload is damaged or its segment missing. kArgument: no such instant.
  base::Result<scene::FrameSet> frame_set(std::size_t index) const;

  // For each camera with plates the newest version of each tile. Tiles that belong to another
  // centre or scale than the newest are left out. Damaged tiles are left out (verify() tells).
  base::Result<std::map<base::CameraId, image::PlateSnapshot>> plates() const;

  // By time, then camera, kind and text.
  base::Result<std::vector<Event>> events() const;

  // Checksums every payload.
  base::Result<VerifyReport> verify(const VerifyOptions& options = {}) const;

 private:
  class Impl;
  explicit SessionReader(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace touchline::session
