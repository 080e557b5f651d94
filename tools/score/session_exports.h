// The exports of a session, made by the hub's own program.
#pragma once

#include <filesystem>
#include <string>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct ExportOptions {
  std::filesystem::path hub;      // touchline-hub
  std::filesystem::path session;  // folder
  std::filesystem::path out;      // made where it is missing; files in it are replaced
  std::string mode = "refined";   // of the renders: refined, hull or billboard
  double voxel_m = 0.02;          // of hulls and renders, metres
};

// Runs `touchline-hub export` for cameras, mattes, hull and people, and `render` with and without
// --foreground along each virtual camera of the truth, for the instants that have a clean picture.
// What the truth knows nothing about is not exported. Fails naming the command that failed.
base::Status export_session(const Truth& truth, const ExportOptions& options);

// touchline-hub beside the program that runs; empty where there is none.
std::filesystem::path hub_beside_this_program();

}  // namespace touchline::score
