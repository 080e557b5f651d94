// Scores on real frames: sets that have no recording with full truth, each scored as far as what is
// known about it allows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/base/result.h"

namespace touchline::score {

struct SetOptions {
  // Folder of all sets (the set itself lies in a folder of it).
  std::filesystem::path data;
  // Where pictures of what was found go; empty = none are written.
  std::filesystem::path pictures;
};

// One figure. NaN = could not be told.
struct SetCell {
  std::string name;  // the column
  double value = 0;
  std::string unit;   // "px", "%", "m", ""
  std::size_t n = 0;  // what it is taken over
};

struct SetRow {
  std::string label;  // what was scored: a method, a clip, a view
  std::vector<SetCell> cells;
};

struct SetReport {
  std::string name;
  std::string what;  // what the frames are and what is known about them, a sentence or two
  std::vector<SetRow> rows;
  std::vector<std::string> notes;  // what was left out and why, how to read the figures
};

// Each fails with kNotFound naming the folder where the data is not there. One function a set, in
// sets/<name>.{h,cc}; sets.cc lists them.
using SetFunction = base::Result<SetReport> (*)(const SetOptions& options);

struct SetEntry {
  std::string name;  // as on the command line
  std::string what;  // one line for --help
  SetFunction run = nullptr;
};

// All sets, in the order of the help.
const std::vector<SetEntry>& sets();

// One table: a line a row, a column for each cell name.
std::string table_text(const SetReport& report);
// {"format_version", "set", "what", "rows": [{"label", "cells": [...]}], "notes"}.
std::string json_text(const SetReport& report);

}  // namespace touchline::score
