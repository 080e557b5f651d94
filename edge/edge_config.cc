#include "edge/edge_config.h"

#include <fmt/format.h>

#include "shared/config/toml_document.h"
#include "shared/recording/still_reader.h"

namespace touchline::edge {
namespace {

void read_link(config::Table table, wire::LinkOptions& link) {
  link.mode = table.choice<wire::Mode>(
      "mode", link.mode, {{"live", wire::Mode::kLive}, {"replay", wire::Mode::kReplay}});
  link.domain = static_cast<int>(table.integer("domain", link.domain, {0, 230}));
  link.tag = table.text("tag", link.tag);
  link.interfaces = table.texts("interfaces", link.interfaces);
  link.peers = table.texts("peers", link.peers);
  link.max_mbit_s = static_cast<int>(table.integer("max_mbit_s", link.max_mbit_s, {1, 16000}));
  link.message_bytes =
      static_cast<std::uint32_t>(table.integer("message_bytes", link.message_bytes, {1200, 65000}));
}

void read_chain(config::Document& document, ChainOptions& chain) {
  config::Table root = document.root();
  config::Table plate = root.table("plate");
  chain.hold_back_s = plate.number("hold_back_s", chain.hold_back_s, {0, 2});
  chain.plate_file.save_frames =
      static_cast<int>(plate.integer("save_frames", chain.plate_file.save_frames, {25, 1000000}));
  chain.plate.update_rate = plate.number("update_rate", chain.plate.update_rate, {0.001, 0.5});
  config::Table key = root.table("key");
  chain.key.weak_sigma = key.number("weak_sigma", chain.key.weak_sigma, {1, 50});
  chain.key.strong_sigma = key.number("strong_sigma", chain.key.strong_sigma, {1, 200});
  chain.key.margin_m = key.number("margin_m", chain.key.margin_m, {0, 50});
  chain.key.tallest_m = key.number("tallest_m", chain.key.tallest_m, {1, 5});
  config::Table encode = root.table("encode");
  chain.encode.tile_margin_px =
      static_cast<int>(encode.integer("tile_margin_px", chain.encode.tile_margin_px, {0, 64}));
  chain.codec.tiles.quality =
      static_cast<int>(encode.integer("tile_quality", chain.codec.tiles.quality, {1, 100}));
  chain.plate_tiles.quality =
      static_cast<int>(encode.integer("plate_quality", chain.plate_tiles.quality, {1, 100}));
}

void read_tracking(config::Document& document, publish::TrackingOptions& tracking) {
  config::Table table = document.root().table("tracking");
  tracking.free_d_to = table.texts("free_d_to", tracking.free_d_to);
  tracking.open_track_io_to = table.texts("open_track_io_to", tracking.open_track_io_to);
  tracking.interface = table.text("interface", tracking.interface);
  tracking.ttl = static_cast<int>(table.integer("ttl", tracking.ttl, {1, 255}));
  tracking.sensor_width_mm = table.number("sensor_width_mm", tracking.sensor_width_mm, {1, 100});
  tracking.free_d_camera_id =
      static_cast<int>(table.integer("free_d_camera_id", tracking.free_d_camera_id, {0, 255}));
  tracking.source_number =
      static_cast<int>(table.integer("source_number", tracking.source_number, {1, 200}));
  tracking.checksum = table.choice<publish::ChecksumOrder>(
      "checksum", tracking.checksum,
      {{"second-sum-first", publish::ChecksumOrder::kSecondSumFirst},
       {"first-sum-first", publish::ChecksumOrder::kFirstSumFirst}});
}

void read_head(config::Document& document, std::optional<head::FreeDReceiverOptions>& head) {
  config::Table table = document.root().table("head");
  head::FreeDReceiverOptions options;
  options.address = table.text("free_d_at", options.address);
  options.port = static_cast<int>(table.integer("free_d_port", 0, {0, 65535}));
  if (const auto id = table.optional_integer("free_d_camera_id", {0, 255}))
    options.camera_id = static_cast<int>(*id);
  options.stale_s = table.number("stale_s", options.stale_s, {0.01, 60});
  if (options.port > 0) head = options;
}

}  // namespace

base::Status EdgeConfig::validate() const {
  if (!base::is_valid(camera)) {
    return base::fail(base::ErrorKind::kConfiguration, "camera",
                      fmt::format("'{}' is not a camera id", camera.value),
                      "use 1 to 32 letters, digits, '-' or '_'");
  }
  if (!(hub_timeout_s >= 1 && hub_timeout_s <= 3600)) {
    return base::fail(base::ErrorKind::kConfiguration, "hub_timeout_s",
                      fmt::format("{} is out of bounds", hub_timeout_s), "use a value in 1..3600");
  }
  if (base::Status status = link.validate(); !status) return status;
  if (base::Status status = tracking.validate(); !status) return status;
  return chain.validate();
}

base::Result<EdgeConfig> load_edge_config(const std::filesystem::path& path) {
  auto document = config::Document::load(path);
  if (!document) return base::fail(document.error());
  EdgeConfig out;
  config::Table camera = document->root().table("camera");
  out.camera.value = camera.text("id", "");
  config::Table source = document->root().table("source");
  const std::string recording = source.text("recording", "");
  if (!recording.empty()) out.recording = path.parent_path() / recording;
  if (source.has("pace")) {
    out.pace = source.choice<capture::Pace>(
        "pace", capture::Pace::kReal,
        {{"max", capture::Pace::kFast}, {"real", capture::Pace::kReal}});
  }
  config::Table wire = document->root().table("wire");
  read_link(wire, out.link);
  out.hub_timeout_s = wire.number("hub_timeout_s", out.hub_timeout_s, {1, 3600});
  read_chain(*document, out.chain);
  if (const auto colours = document->root().table("key").optional_text("colours")) {
    out.chain.key_colours = path.parent_path() / *colours;
    std::error_code error;
    if (std::filesystem::exists(out.chain.key_colours, error)) {
      auto training = key::load_colour_training(out.chain.key_colours);
      if (!training) return base::fail(training.error());
      out.chain.key.colours = std::move(*training);
    }
  }
  if (const auto file = document->root().table("plate").optional_text("file"))
    out.chain.plate_file.load = out.chain.plate_file.save = path.parent_path() / *file;
  read_head(*document, out.head);
  read_tracking(*document, out.tracking);
  if (base::Status status = document->finish(); !status) return base::fail(status.error());
  return out;
}

base::Result<ChainSetup> chain_setup(const recording::Recording& recording,
                                     const base::CameraId& camera) {
  const recording::CameraEntry* entry = recording.find(camera);
  if (entry == nullptr) {
    std::string there;
    for (const recording::CameraEntry& e : recording.cameras)
      there += (there.empty() ? "" : ", ") + e.id.value;
    return base::fail(base::ErrorKind::kArgument, "--camera",
                      fmt::format("{} has no camera '{}'", recording.name, camera.value),
                      "it has: " + there);
  }
  ChainSetup setup;
  setup.camera = camera;
  switch (entry->role) {
    case recording::Role::kMatch:
      setup.kind = HeadKind::kHead;
      break;
    case recording::Role::kFixed:
      setup.kind = HeadKind::kFixed;
      break;
    case recording::Role::kCloseup:
      setup.kind = HeadKind::kCloseup;
      break;
  }
  switch (entry->side) {
    case recording::Side::kMain:
      setup.side = calibrate::Side::kMain;
      break;
    case recording::Side::kReverse:
      setup.side = calibrate::Side::kReverse;
      break;
    case recording::Side::kLeft:
      setup.side = calibrate::Side::kLeft;
      break;
    case recording::Side::kRight:
      setup.side = calibrate::Side::kRight;
      break;
  }
  setup.sport = recording.sport;
  setup.sizes = recording.sizes;
  setup.rate = entry->rate;
  return setup;
}

SurveyStills load_stills(const recording::CameraEntry& camera) {
  SurveyStills out;
  if (camera.survey.empty()) return out;
  auto paths = recording::survey_stills(camera);
  if (!paths) {
    out.troubles.push_back(paths.error());
    return out;
  }
  for (const std::filesystem::path& path : *paths) {
    auto still = recording::read_still(path);
    if (!still) {
      out.troubles.push_back(still.error());
    } else if (still->width() != camera.width || still->height() != camera.height) {
      out.troubles.push_back({base::ErrorKind::kConfiguration, path.string(),
                              fmt::format("a still of {}x{} for a camera of {}x{}", still->width(),
                                          still->height(), camera.width, camera.height),
                              "take the stills from the camera's own output"});
    } else {
      out.frames.push_back(std::move(*still));
    }
  }
  return out;
}

base::Result<std::unique_ptr<head::HeadSource>> open_head(const EdgeConfig& config,
                                                          const recording::CameraEntry& camera,
                                                          const runtime::Clock& clock) {
  if (config.head) {
    auto receiver = head::FreeDReceiver::open(*config.head, clock);
    if (!receiver) return base::fail(receiver.error());
    return std::move(*receiver);
  }
  if (camera.head.empty()) return nullptr;
  auto rows = recording::read_head_table(camera.head);
  if (!rows) return base::fail(rows.error());
  return std::make_unique<head::RecordedHead>(std::move(*rows));
}

}  // namespace touchline::edge
