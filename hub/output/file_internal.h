// Files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>

#include "shared/base/result.h"

namespace touchline::output {

// Writes to a name beside the target, then renames; the partial file is removed on failure.
base::Status write_whole(const std::filesystem::path& path, const void* bytes, std::size_t size);

}  // namespace touchline::output
