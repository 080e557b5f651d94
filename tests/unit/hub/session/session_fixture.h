// Sessions to read and to break.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hub/session/session_reader.h"
#include "hub/session/session_writer.h"
#include "shared/codec/plate_codec.h"
#include "shared/codec/view_codec.h"
#include "tests/support/folders.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::session::samples {

inline SessionInfo info() {
  SessionInfo info;
  info.name = "friendly";
  info.sizes.length_m = 104.5;
  info.sizes.crown_m = 0.3;
  info.start_timecode = {10, 0, 0, 0, false};
  info.start = base::MediaTime{0};
  info.cameras = {{{"m1"}, recording::Role::kMatch, recording::Side::kMain, 64, 48},
                  {{"f1"}, recording::Role::kFixed, recording::Side::kReverse, 64, 48}};
  return info;
}

inline codec::EncodedView view(const std::string& camera, std::uint64_t sequence) {
  return *codec::encode(touchline::samples::view(camera, sequence));
}

inline codec::EncodedPlateTile plate_tile(const std::string& camera, std::uint32_t version,
                                          image::PlateTileKey key) {
  image::PlateSnapshot plate;
  plate.version = version;
  plate.radians_per_px = 0.0003;
  plate.centre_in_world = {0, -60, 12};
  plate.tiles[key] = touchline::samples::plate_tile(version);
  return *codec::encode_plate_tile({camera}, plate, key, {.quality = 30});
}

// All that `reader` hands out, as text with the codec bytes in it: equal text, equal exports.
inline std::string everything(const SessionReader& reader) {
  std::string out;
  for (std::size_t i = 0; i < reader.instants().size(); ++i) {
    out += std::to_string(reader.instants()[i].ns) + "/" + std::to_string(reader.frame_number(i));
    const auto set = reader.frame_set(i);
    if (!set) return to_string(set.error());
    for (const scene::FrameSetEntry& entry : set->entries) {
      out += " " + entry.camera.value + ":";
      if (const auto* absent = std::get_if<scene::Absent>(&entry.view)) {
        out += scene::name(absent->reason);
        continue;
      }
      const auto& encoded = std::get<codec::EncodedView>(entry.view);
      out += std::to_string(encoded.id.epoch) + "." + std::to_string(encoded.id.sequence);
      for (const auto& part : encoded.parts) out.append(part.bytes.begin(), part.bytes.end());
    }
    out += "\n";
  }
  const auto events = reader.events();
  for (const Event& event : *events) {
    out += event.camera.value + event.kind + event.text + std::to_string(event.time.ns) + "\n";
  }
  return out;
}

}  // namespace touchline::session::samples
