// Do the cameras agree about people? A pitch maps onto itself when turned by 180 degrees, so lines
// cannot tell on which side a camera stands: the installer states it, and a camera whose side was
// stated wrongly is solved as its mirror image. Only what stands on the pitch gives it away.
//
// Where one camera sees someone's feet, another that sees the same place must see someone too. Each
// pair of cameras is compared as stated and with one of them turned; what counts is how much more
// often someone is found than at places nearby where nobody was claimed. Cameras that look at
// different parts of the pitch say nothing about each other.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

struct SideOptions {
  double found_share = 0.75;  // of people whom another camera finds where they are; 0.3..0.99
  double cell_m = 1.5;        // people in one cell count once, at whatever instant; metres, 0.3..10
  // How much more likely a turned camera must make everything, as a natural logarithm, before it is
  // named; 1..100. 8 are odds of 3000 to 1.
  double least_evidence = 8;
  int least_places = 5;  // cells in which people agree, below which nothing is said; 2..1000

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

// Cameras that agree with the others only when turned by 180 degrees.
struct TurnedCameras {
  // The smaller part of those that can be compared, in configuration order; where both parts are
  // equally large, all of them.
  std::vector<base::CameraId> cameras;
  bool undecided = false;  // both parts are equally large: one of them is turned
  double evidence = 0;     // logarithm of the odds, of the least sure of them
  int places = 0;          // where people agree only when turned
};

struct SideReport {
  std::vector<TurnedCameras> turned;     // empty when nothing speaks against what was stated
  std::vector<base::CameraId> agreeing;  // confirmed by other cameras, in configuration order
  int pairs = 0;                         // of cameras that could be compared
};

class SideCheck {
 public:
  // `options` must be valid.
  explicit SideCheck(pitch::PitchModel pitch, const SideOptions& options = {});
  SideCheck(SideCheck&&) noexcept;
  SideCheck& operator=(SideCheck&&) noexcept;
  ~SideCheck();

  // The views of one instant. Instants a second apart or more say more than neighbours do. Lost
  // cameras and views without a matte say nothing.
  void add(std::span<const codec::CameraView> views);

  SideReport report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::track
