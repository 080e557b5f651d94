// Writes a session: a folder with index.sqlite and payloads in checksummed segment files, codec
// bytes verbatim.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "hub/session/session_info.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"

namespace touchline::session {

struct WriterOptions {
  bool overwrite =
      false;  // replace a session that is there; anything else in the folder is refused
  std::uint64_t segment_bytes = 256u << 20;  // a segment that has reached this is closed, >= 4096

  base::Status validate() const;
};

// For one thread. Each append first writes the payload, then its row in the index, so that a hub
// killed at any moment leaves a session that reads up to its last whole append. An append that
// fails (disk full) leaves what was written readable and may be tried again.
class SessionWriter {
 public:
  // kArgument when `folder` holds a session already (unless overwrite) or other files, or the
  // information is inconsistent (two cameras of one name, a bad rate).
  static base::Result<SessionWriter> create(const std::filesystem::path& folder,
                                            const SessionInfo& info,
                                            const WriterOptions& options = {});
  SessionWriter(SessionWriter&&) noexcept;
  SessionWriter& operator=(SessionWriter&&) noexcept;
  ~SessionWriter();  // closes; without finish() the session says that it is not finished

  // kArgument for a camera that is not configured. A view or tile that is there already (same frame
  // id; same camera, key and plate version) is kept once: the first.
  base::Status append(const codec::EncodedView& view);
  base::Status append(const codec::EncodedPlateTile& tile);
  base::Status append(const Event& event);

  // Brings everything to the disk and closes; the index is then a single file. Nothing may be
  // appended afterwards.
  base::Status finish();

  std::uint64_t bytes_written() const;  // payloads with their headers

 private:
  class Impl;
  explicit SessionWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::session
