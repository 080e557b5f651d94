// The index: its tables, and the information in it.
#pragma once

#include <filesystem>

#include "hub/session/database_internal.h"
#include "hub/session/session_info.h"

namespace touchline::session {

inline constexpr const char* kIndexName = "index.sqlite";
inline constexpr std::int64_t kApplicationId = 0x544c5353;  // "TLSS"

base::Status check(const SessionInfo& info);

// In one transaction: the tables and what `info` says.
base::Status write_schema(Database& database, const SessionInfo& info);

// kUnsupported by number for another format version.
base::Result<SessionInfo> read_info(const Database& database, const std::filesystem::path& file);

}  // namespace touchline::session
