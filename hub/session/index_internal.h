// The rows of a session's index in memory.
#pragma once

#include <compare>
#include <filesystem>
#include <vector>

#include "hub/session/segment_internal.h"
#include "hub/session/session_info.h"
#include "shared/base/result.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::session {

struct ViewRow {
  std::size_t camera = 0;  // in configuration order
  std::uint32_t epoch = 0;
  std::uint64_t sequence = 0;
  base::MediaTime time;
  RecordPlace place;
};

struct PlateRow {
  std::size_t camera = 0;
  image::PlateTileKey key;
  std::uint32_t epoch = 0;
  std::uint32_t version = 0;
  RecordPlace place;
};

struct Index {
  SessionInfo info;
  bool finished = false;
  std::vector<ViewRow> views;    // by camera, epoch, sequence
  std::vector<PlateRow> plates;  // by camera, key, epoch, version
  std::vector<Event> events;     // sorted
};

// Errors as SessionReader::open() has them.
base::Result<Index> read_index(const std::filesystem::path& folder);

}  // namespace touchline::session
