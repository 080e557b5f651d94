// From a session to pictures: session > decode > hull > track > render. One instant at a time;
// every stage works in parallel inside and gives the same bytes at any thread count.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "hub/decode/decode_set.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "hub/scene/hull.h"
#include "hub/scene/people.h"
#include "hub/session/session_reader.h"
#include "shared/base/result.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::hub {

struct ShotOptions {
  hull::HullOptions hull;
  render::RenderOptions render;
  render::ColourReferenceOptions colour;
  codec::DecodeLimits limits;
};

// Seconds spent since the shot was opened.
struct ShotTimes {
  double open_s = 0;  // plates, colour reference, stadium
  double decode_s = 0;
  double hull_s = 0;
  double render_s = 0;
  int pictures = 0;
};

// One instant, decoded and carved.
struct Instant {
  std::int64_t frame = 0;
  decode::DecodedSet set;
  scene::Hull hull;
};

class Shot {
 public:
  static base::Result<Shot> open(const std::filesystem::path& session_folder,
                                 const ShotOptions& options);
  Shot(Shot&&) noexcept;
  Shot& operator=(Shot&&) noexcept;
  ~Shot();

  const session::SessionReader& session() const;
  const pitch::PitchModel& pitch() const;
  // Frame numbers the session has, rising.
  const std::vector<std::int64_t>& frames() const;

  // The views of a frame, decoded; kNotFound names the frames there are.
  base::Result<decode::DecodedSet> decode(std::int64_t frame);
  // The same with its hull. The last one is kept, so that a frozen shot carves once.
  base::Result<std::shared_ptr<const Instant>> instant(std::int64_t frame);

  // The picture of a virtual camera at a frame; `foreground` leaves people and ball alone.
  base::Result<render::RenderResult> render(std::int64_t frame,
                                            const geometry::CameraEstimate& virtual_camera,
                                            render::Mode mode, bool foreground);

  ShotTimes times() const;

 private:
  struct Impl;
  explicit Shot(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::hub
