// A camera estimate -> an OpenTrackIO sample (JSON) and the UDP packets that carry it.
// Source: SMPTE RIS OSVP, OpenTrackIO documentation 1.0.1 (opentrackio.org): "OpenTrackIO sample",
// "Packet Header", "Description of all fields"; lens terms by "Conversion of OpenCV to OpenTrackIO
// (OpenLensIO)".
//
// The stage is the pitch frame (X along the pitch, Y across, Z up, metres). OpenTrackIO turns
// right-handed about Z, X, Y in this order, [pan, tilt, roll], and looks along +Y at zero: its pan
// is the negative of ours, tilt and roll are the same. The transform is that of the entrance pupil.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::publish {

struct OpenTrackIoOptions {
  int source_number = 1;          // by which receivers tell sources apart; 1..200
  double sensor_width_mm = 9.59;  // of what the picture's width is taken to be; 1..100
  std::string system;             // units of one production; goes into the source's identity
};

// What a sample says beside the estimate.
struct SampleContext {
  base::FrameId frame;
  base::FrameStamp stamp;
  base::FrameRate rate;
  bool with_static = false;  // add what does not change; recommended every 2 s
};

// One sample. The sample's and the source's UUIDs are made from the frame's identity, so the same
// frame of the same run gives the same bytes. A lost camera's sample has status "lost" and neither
// transforms nor lens: nothing that could be drawn with. Distortion is given as "Brown-Conrady U-D"
// with radial {k1/F^2, 0, k2/F^4, 0, 0, 0}, F in mm; projectionOffset is x right, y down, in mm.
std::string open_track_io_sample(const geometry::CameraEstimate& estimate,
                                 const SampleContext& context, const OpenTrackIoOptions& options);

// Which sum of the Fletcher checksum (modulo 256) comes first in the header: receivers differ, and
// so do the documentation's editions. The second sum first is what Unreal Engine reads.
enum class ChecksumOrder : std::uint8_t { kSecondSumFirst, kFirstSumFirst };

// The sample in packets with the 16-byte header, in order, each with at most `most_payload` bytes
// of it (1..32767). The sequence number is the same in all packets of a sample.
std::vector<std::vector<std::uint8_t>> open_track_io_packets(const std::string& sample,
                                                             std::uint16_t sequence,
                                                             ChecksumOrder order,
                                                             std::size_t most_payload = 1456);

}  // namespace touchline::publish
