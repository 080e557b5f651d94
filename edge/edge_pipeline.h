// The edge unit at work: capture, process and publish threads with bounded queues between them.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "edge/capture/frame_source.h"
#include "edge/edge_config.h"
#include "edge/frame_chain.h"
#include "edge/publish/tracking_out.h"
#include "shared/base/result.h"

namespace touchline::edge {

struct EdgeReport {
  ChainReport chain;
  std::uint64_t frames_read = 0;
  std::uint64_t frames_sent = 0;
  std::uint64_t frames_dropped = 0;  // live only: the oldest made room
  std::uint64_t bytes_sent = 0;
  publish::TrackingCounts tracking;  // to graphics engines
  // What went wrong although everything that could be sent was sent: a truncated video, a failed
  // survey.
  std::optional<base::Error> trouble;
};

// `epoch` is that of the frames of `source`; `head` are the encoders, or null. Runs until the
// source ends or a stop is requested. An Error means that the hub could not be served to the end;
// the trouble of a source or a survey is in the report, and the hub has been told.
base::Result<EdgeReport> run_edge(const EdgeConfig& config, const ChainSetup& setup,
                                  const std::string& source_name, capture::FrameSource& source,
                                  SurveyStills stills, head::HeadSource* head, std::uint32_t epoch,
                                  std::stop_token stop);

}  // namespace touchline::edge
