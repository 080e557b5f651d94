#include "tools/score/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "shared/recording/camera_table.h"
#include "tools/score/csv.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

// A size of 0 keeps the table's own: that of a picture centred on the principal point.
base::Result<std::map<std::int64_t, geometry::CameraEstimate>> read_cameras(const fs::path& path,
                                                                            int width, int height) {
  const auto rows = recording::read_camera_table(path);
  if (!rows) return base::fail(rows.error());
  std::map<std::int64_t, geometry::CameraEstimate> cameras;
  for (const recording::CameraRow& row : *rows) {
    geometry::CameraEstimate camera;
    camera.model = row.model;
    if (width > 0) camera.model.width = width;
    if (height > 0) camera.model.height = height;
    camera.cam_from_world = row.cam_from_world;
    camera.evidence = geometry::Evidence::kLines;
    cameras[row.frame] = camera;
  }
  return cameras;
}

// A table of `frame`, text columns and x, y, z; calls add(frame, texts, position).
template <typename Add>
base::Status read_points(const fs::path& path, const std::vector<std::string>& texts, Add add) {
  const auto table = CsvTable::read(path);
  if (!table) return base::fail(table.error());
  std::vector<std::size_t> text_columns;
  for (const std::string& name : texts) {
    const auto column = table->column(name);
    if (!column) return base::fail(column.error());
    text_columns.push_back(*column);
  }
  std::array<std::size_t, 4> columns{};
  constexpr std::array<const char*, 4> kNames = {"frame", "x", "y", "z"};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto column = table->column(kNames[i]);
    if (!column) return base::fail(column.error());
    columns[i] = *column;
  }
  for (std::size_t row = 0; row < table->rows(); ++row) {
    const auto frame = table->frame(row, columns[0]);
    if (!frame) return base::fail(frame.error());
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    for (std::size_t i = 1; i < columns.size(); ++i) {
      const auto number = table->number(row, columns[i]);
      if (!number) return base::fail(number.error());
      position[static_cast<Eigen::Index>(i - 1)] = *number;
    }
    std::vector<std::string> cells;
    for (const std::size_t column : text_columns) cells.push_back(table->text(row, column));
    add(*frame, cells, position);
  }
  return {};
}

base::Result<cv::Mat> read_png(const fs::path& path, int flags) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "is not there",
                      "check the folder");
  }
  cv::Mat picture;
  try {
    picture = cv::imread(path.string(), flags);
  } catch (const cv::Exception&) {
    picture.release();  // sizes beyond any bound
  }
  if (picture.empty()) {
    return base::fail(base::ErrorKind::kFormat, path.string(), "is no PNG, or cut short",
                      "write it again");
  }
  return picture;
}

}  // namespace

std::vector<std::int64_t> numbered_files(const fs::path& folder, const std::string& extension) {
  std::vector<std::int64_t> frames;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string stem = it->path().stem().string();
    if (it->path().extension() == extension && stem.size() == 6 &&
        std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; })) {
      frames.push_back(std::stoll(stem));
    }
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

base::Result<image::Image<std::uint8_t>> read_grey_png(const fs::path& path) {
  const auto picture = read_png(path, cv::IMREAD_GRAYSCALE);
  if (!picture) return base::fail(picture.error());
  image::Image<std::uint8_t> out(picture->cols, picture->rows);
  for (int y = 0; y < out.height(); ++y) {
    const std::uint8_t* row = picture->ptr<std::uint8_t>(y);
    std::copy(row, row + out.width(), out.row(y));
  }
  return out;
}

base::Result<image::Image<std::uint8_t>> read_alpha_png(const fs::path& path) {
  const auto picture = read_png(path, cv::IMREAD_UNCHANGED);
  if (!picture) return base::fail(picture.error());
  if (picture->type() != CV_8UC4) {
    return base::fail(base::ErrorKind::kFormat, path.string(), "has no 8-bit alpha channel",
                      "render it with --foreground");
  }
  image::Image<std::uint8_t> out(picture->cols, picture->rows);
  for (int y = 0; y < out.height(); ++y) {
    const cv::Vec4b* row = picture->ptr<cv::Vec4b>(y);
    for (int x = 0; x < out.width(); ++x) out(x, y) = row[x][3];
  }
  return out;
}

base::Result<image::Image<image::Rgb8>> read_rgb_png(const fs::path& path) {
  const auto picture = read_png(path, cv::IMREAD_COLOR);
  if (!picture) return base::fail(picture.error());
  image::Image<image::Rgb8> out(picture->cols, picture->rows);
  for (int y = 0; y < out.height(); ++y) {
    const cv::Vec3b* row = picture->ptr<cv::Vec3b>(y);
    for (int x = 0; x < out.width(); ++x) out(x, y) = {row[x][2], row[x][1], row[x][0]};
  }
  return out;
}

base::Result<Truth> Truth::open(const recording::Recording& recording) {
  Truth truth;
  truth.root_ = recording.root / "truth";
  std::error_code error;
  if (!fs::is_directory(truth.root_, error)) {
    return base::fail(base::ErrorKind::kNotFound, truth.root_.string(), "is not there",
                      "score a recording that has its truth");
  }
  for (const recording::CameraEntry& entry : recording.cameras) {
    const fs::path path = truth.root_ / entry.id.value / "cameras.csv";
    if (!fs::exists(path, error)) continue;
    auto rows = read_cameras(path, entry.width, entry.height);
    if (!rows) return base::fail(rows.error());
    truth.cameras_[entry.id] = std::move(*rows);
  }
  for (const auto& folder : fs::directory_iterator(truth.root_, error)) {
    const std::string name = folder.path().filename().string();
    if (name.rfind("virtual", 0) != 0 || !fs::exists(folder.path() / "cameras.csv", error)) {
      continue;
    }
    auto rows = read_cameras(folder.path() / "cameras.csv", 0, 0);
    if (!rows) return base::fail(rows.error());
    truth.cameras_[{name}] = std::move(*rows);
    truth.virtual_cameras_.push_back({name});
  }
  std::sort(truth.virtual_cameras_.begin(), truth.virtual_cameras_.end());
  if (fs::exists(truth.root_ / "people.csv", error)) {
    const auto status = read_points(
        truth.root_ / "people.csv", {"id", "team", "role"},
        [&](std::int64_t frame, const std::vector<std::string>& c, const Eigen::Vector3d& p) {
          truth.people_[frame].push_back({c[0], c[1], c[2], p});
        });
    if (!status) return base::fail(status.error());
  }
  if (fs::exists(truth.root_ / "joints.csv", error)) {
    const auto status = read_points(
        truth.root_ / "joints.csv", {"id", "joint"},
        [&](std::int64_t frame, const std::vector<std::string>& c, const Eigen::Vector3d& p) {
          truth.joints_[frame].push_back({c[0], c[1], p});
        });
    if (!status) return base::fail(status.error());
  }
  return truth;
}

std::optional<geometry::CameraEstimate> Truth::camera(const base::CameraId& camera,
                                                      std::int64_t frame) const {
  const auto rows = cameras_.find(camera);
  if (rows == cameras_.end()) return std::nullopt;
  const auto row = rows->second.find(frame);
  if (row == rows->second.end()) return std::nullopt;
  return row->second;
}

std::size_t Truth::camera_rows(const base::CameraId& camera) const {
  const auto rows = cameras_.find(camera);
  return rows == cameras_.end() ? 0 : rows->second.size();
}

std::vector<std::int64_t> Truth::camera_frames(const base::CameraId& camera) const {
  std::vector<std::int64_t> frames;
  const auto rows = cameras_.find(camera);
  if (rows == cameras_.end()) return frames;
  for (const auto& [frame, row] : rows->second) frames.push_back(frame);
  return frames;
}

const std::vector<TruePerson>& Truth::people(std::int64_t frame) const {
  static const std::vector<TruePerson> kNobody;
  const auto at = people_.find(frame);
  return at == people_.end() ? kNobody : at->second;
}

std::vector<std::int64_t> Truth::people_frames() const {
  std::vector<std::int64_t> frames;
  for (const auto& [frame, people] : people_) frames.push_back(frame);
  return frames;
}

const std::vector<TrueJoint>& Truth::joints(std::int64_t frame) const {
  static const std::vector<TrueJoint> kNone;
  const auto at = joints_.find(frame);
  return at == joints_.end() ? kNone : at->second;
}

base::Result<image::Image<std::uint8_t>> Truth::matte(const base::CameraId& camera,
                                                      std::int64_t frame) const {
  return read_grey_png(root_ / camera.value / "matte" / fmt::format("{:06}.png", frame));
}

base::Result<image::Image<image::Rgb8>> Truth::clean(const base::CameraId& camera,
                                                     std::int64_t frame) const {
  return read_rgb_png(root_ / camera.value / "clean" / fmt::format("{:06}.png", frame));
}

base::Result<geometry::Mesh> Truth::mesh(std::int64_t frame) const {
  return read_ply(root_ / "mesh" / fmt::format("{:06}.ply", frame));
}

std::vector<std::int64_t> Truth::mesh_frames() const {
  return numbered_files(root_ / "mesh", ".ply");
}

std::vector<std::int64_t> Truth::matte_frames(const base::CameraId& camera) const {
  return numbered_files(root_ / camera.value / "matte", ".png");
}

std::vector<std::int64_t> Truth::clean_frames(const base::CameraId& camera) const {
  return numbered_files(root_ / camera.value / "clean", ".png");
}

std::vector<int> assign_vertices(const geometry::Mesh& mesh, const std::vector<TruePerson>& people,
                                 double reach_m) {
  constexpr double kBallRadius = 0.11;
  std::vector<int> owners;
  owners.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3d point = vertex.cast<double>();
    int owner = -1;
    double nearest = reach_m;
    for (std::size_t i = 0; i < people.size(); ++i) {
      const Eigen::Vector3d offset = point - people[i].position_in_world;
      if (people[i].is_ball()) {
        // The ball's surface is at a known distance, so that a boot beside it is told apart.
        if (std::abs(offset.norm() - kBallRadius) < 0.002) {
          owner = static_cast<int>(i);
          break;
        }
        continue;
      }
      const double distance = offset.head<2>().norm();
      if (distance < nearest) {
        nearest = distance;
        owner = static_cast<int>(i);
      }
    }
    owners.push_back(owner);
  }
  return owners;
}

}  // namespace touchline::score
