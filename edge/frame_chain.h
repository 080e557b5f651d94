// One camera's frames through every stage of the edge, in order and without threads: compensate,
// calibrate, plate, key, encode. The pipeline feeds it; tests and benches call it as it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "edge/calibrate/survey/survey.h"
#include "edge/chain_setup.h"
#include "edge/compensate/burnt_in.h"
#include "edge/compensate/detail_estimator.h"
#include "edge/encode/assemble.h"
#include "edge/head_follower.h"
#include "edge/key/key.h"
#include "edge/mount_finder.h"
#include "edge/peer_follower.h"
#include "edge/plate/plate_builder.h"
#include "edge/plate_keeper.h"
#include "edge/stage_time.h"
#include "edge/state/detail_model.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"
#include "shared/codec/plate_codec.h"
#include "shared/codec/view_codec.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/runtime/executor.h"

namespace touchline::edge {

struct ChainOptions {
  double hold_back_s = 2;  // frames held at the start while detail and plate are learnt; 0..2
  int hold_back_mib =
      560;  // and no more than this of them, MiB (2160p frames take 32 each); 16..65536
  int detail_frames = 6;  // of those, how many the detail estimate looks at; 1..50
  int plate_publish_frames =
      250;  // frames between two looks at which plate tiles changed; 1..100000
  compensate::DetailOptions detail;
  compensate::BurntInOptions burnt_in;
  MountOptions mount;
  HeadOptions head;
  PeerOptions peers;
  plate::PlateOptions plate;
  PlateKeepOptions plate_file;
  key::KeyOptions key;
  std::filesystem::path key_colours;  // where the operator's colours are kept; empty: nowhere
  encode::EncodeOptions encode;
  codec::EncodeOptions codec;
  codec::PlateTileOptions plate_tiles;

  base::Status validate() const;
};

// What came out for frames that went in: views in frame order, and plate tiles that changed.
struct ChainOutput {
  std::vector<codec::EncodedView> views;
  std::vector<codec::EncodedPlateTile> plates;
  std::vector<std::string> notes;  // for the log and the unit's status, in order
};

struct ChainReport {
  std::uint64_t frames_in = 0;
  std::uint64_t frames_out = 0;
  std::uint64_t frames_lost = 0;      // without a camera estimate
  std::uint64_t frames_by_head = 0;   // by the head's encoders alone
  std::uint64_t frames_by_peers = 0;  // by people whom other cameras see, alone
  std::uint64_t encode_failures = 0;  // frames or plate tiles that no codec took
  geometry::Evidence calibration = geometry::Evidence::kLost;  // of the latest frame
  state::DetailModel detail;
  double survey_rms_px = 0;
  int survey_solved = 0;
  std::vector<StageTime> stages;
  // The camera could not be surveyed although its kind promises that it can.
  std::optional<base::Error> survey_error;
};

// Undoes the camera's detail setting in its survey stills, in place.
void compensate_stills(const compensate::DetailOptions& options, std::vector<image::Frame>& stills);

// Mount and lens of a head from its survey stills, which are compensated in place. The chain does
// this itself; `survey` and `check` show it to the installer.
base::Result<calibrate::SurveyResult> survey_mount(const ChainSetup& setup,
                                                   const ChainOptions& options,
                                                   std::vector<image::Frame>& stills);

class FrameChain {
 public:
  // `stills` are the survey stills of a head (empty where there are none). The mount is solved
  // here. Slow work while running goes to the executor; without one it is done at once. `head` are
  // its encoders, where it has some. Both must outlive the chain.
  static base::Result<FrameChain> make(const ChainSetup& setup, const ChainOptions& options,
                                       std::vector<image::Frame> stills,
                                       runtime::Executor* executor = nullptr,
                                       head::HeadSource* head = nullptr);
  FrameChain(FrameChain&&) noexcept;
  FrameChain& operator=(FrameChain&&) noexcept;
  ~FrameChain();

  // Before the first frame: pictures spread over the take that will be played, in order, for a head
  // without survey stills. Where its mount is found in them, all frames are solved on it, the first
  // as well as the last, and graphics that are burnt into them are masked: no stage looks at what
  // is under them, and mattes say that it is not known. For recorded takes only; without effect on
  // any other camera.
  void look_ahead(std::vector<image::FramePtr> pictures);
  // The next frame. Nothing comes out during the hold-back; then everything held, then each frame
  // as it comes. A frame that cannot be encoded still comes out, without parts, with a note and
  // counted.
  ChainOutput push(image::FramePtr frame);
  // What the operator says of the key's colours, from the next frame on (key/training_order.h has
  // the words). What came of it is a note of the next output.
  void train_key(std::string_view order);
  // People whom another camera sees, as the hub tells; for frames that cannot be solved otherwise.
  void hear(PeopleSeen people);
  // No more frames: what is held, and the tiles of the final plate.
  ChainOutput finish();
  // Writes the plate to its file, if it has one: at the end of a run, finished or stopped.
  base::Status save_plate();

  ChainReport report() const;

 private:
  struct Impl;
  explicit FrameChain(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::edge
