#include "tests/unit/tools/score/true_exports.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "hub/hull/carve.h"
#include "tools/score/oracle.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

std::string numbered(std::int64_t frame, const char* extension) {
  return fmt::format("{:06}{}", frame, extension);
}

void write_mesh(const fs::path& path, const std::vector<geometry::Mesh>& meshes) {
  std::size_t vertices = 0, triangles = 0;
  for (const geometry::Mesh& mesh : meshes) {
    vertices += mesh.vertices.size();
    triangles += mesh.triangles.size();
  }
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << vertices
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << triangles
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const geometry::Mesh& mesh : meshes) {
    out.write(reinterpret_cast<const char*>(mesh.vertices.data()),
              static_cast<std::streamsize>(mesh.vertices.size() * sizeof(Eigen::Vector3f)));
  }
  std::uint32_t first = 0;
  for (const geometry::Mesh& mesh : meshes) {
    for (auto triangle : mesh.triangles) {
      for (std::uint32_t& corner : triangle) corner += first;
      out.put(3);
      out.write(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
    }
    first += static_cast<std::uint32_t>(mesh.vertices.size());
  }
}

}  // namespace

TrueExports::TrueExports() {
  auto recording = recording::load_recording("tests/data/sample");
  EXPECT_TRUE(recording) << to_string(recording.error());
  recording_ = std::move(*recording);
  auto truth = Truth::open(recording_);
  EXPECT_TRUE(truth) << to_string(truth.error());
  truth_ = std::move(*truth);
}

void TrueExports::write_cameras(
    const std::function<void(const std::string&, recording::CameraRow&)>& spoil) const {
  fs::create_directories(folder() / "cameras");
  for (const recording::CameraEntry& entry : recording_.cameras) {
    auto rows = recording::read_camera_table(truth_.root() / entry.id.value / "cameras.csv");
    ASSERT_TRUE(rows) << to_string(rows.error());
    for (recording::CameraRow& row : *rows) {
      row.report = recording::CameraRowReport{geometry::Evidence::kLines, 0.1, 0.01, 0.01, 0.001};
      if (spoil) spoil(entry.id.value, row);
    }
    ASSERT_TRUE(
        recording::write_camera_table(folder() / "cameras" / (entry.id.value + ".csv"), *rows));
  }
}

void TrueExports::write_mattes(const std::string& camera, const SpoilMatte& spoil) const {
  fs::create_directories(folder() / "mattes");
  const fs::path from = fs::absolute(truth_.root() / camera / "matte");
  const fs::path to = folder() / "mattes" / camera;
  if (!spoil) return fs::create_directory_symlink(from, to);
  fs::create_directories(to);
  for (const std::int64_t frame : truth_.matte_frames({camera})) {
    auto matte = truth_.matte({camera}, frame);
    ASSERT_TRUE(matte) << to_string(matte.error());
    spoil(frame, *matte);
    const cv::Mat picture(matte->height(), matte->width(), CV_8UC1, matte->data());
    ASSERT_TRUE(cv::imwrite((to / numbered(frame, ".png")).string(), picture,
                            {cv::IMWRITE_PNG_COMPRESSION, 1}));
  }
}

void TrueExports::write_hulls() const {
  fs::create_directories(folder() / "hull");
  OracleOptions options;
  options.tiles = false;
  auto oracle = Oracle::open(recording_, truth_, options);
  ASSERT_TRUE(oracle) << to_string(oracle.error());
  for (const std::int64_t frame : truth_.mesh_frames()) {
    oracle->skip_to(frame);
    const auto views = oracle->next();
    ASSERT_TRUE(views && *views);
    std::vector<geometry::Mesh> meshes;
    for (const scene::HullGroup& group :
         hull::carve(**views, oracle->pitch(), hull::HullOptions()).hull.groups) {
      if (!group.phantom) meshes.push_back(group.surface);
    }
    write_mesh(folder() / "hull" / numbered(frame, ".ply"), meshes);
  }
}

void TrueExports::write_people(const std::function<void(TruePerson&, std::int64_t)>& spoil) const {
  fs::create_directories(folder() / "people");
  std::string text = "frame,id,team,role,x,y,z,sd_x,sd_y\n";
  for (const std::int64_t frame : truth_.people_frames()) {
    for (TruePerson person : truth_.people(frame)) {
      if (spoil) spoil(person, frame);
      const Eigen::Vector3d& p = person.position_in_world;
      text += fmt::format("{},{},{},{},{:.17g},{:.17g},{:.17g},0.1,0.1\n", frame, person.id,
                          person.team, person.role, p.x(), p.y(), p.z());
    }
  }
  support::write_text(folder() / "people" / "people.csv", text);
}

void TrueExports::write_views(int shift_px) const {
  for (const base::CameraId& id : truth_.virtual_cameras()) {
    const fs::path opaque = folder() / "renders" / id.value;
    const fs::path alone = folder() / "foreground" / id.value;
    fs::create_directories(opaque);
    fs::create_directories(alone);
    for (const std::int64_t frame : truth_.clean_frames(id)) {
      const auto clean = truth_.clean(id, frame);
      const auto matte = truth_.matte(id, frame);
      ASSERT_TRUE(clean && matte);
      cv::Mat bgra(clean->height(), clean->width(), CV_8UC4);
      cv::Mat bgr(clean->height(), clean->width(), CV_8UC3);
      for (int y = 0; y < clean->height(); ++y) {
        for (int x = 0; x < clean->width(); ++x) {
          const int from = std::max(x - shift_px, 0);
          const image::Rgb8& p = (*clean)(from, y);
          bgr.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
          bgra.at<cv::Vec4b>(y, x) = {p.b, p.g, p.r, (*matte)(from, y)};
        }
      }
      const std::vector<int> fast = {cv::IMWRITE_PNG_COMPRESSION, 1};
      ASSERT_TRUE(cv::imwrite((opaque / numbered(frame, ".png")).string(), bgr, fast));
      ASSERT_TRUE(cv::imwrite((alone / numbered(frame, ".png")).string(), bgra, fast));
    }
  }
}

base::Result<ScoreReport> TrueExports::score() const {
  ScoreOptions options;
  options.exports = folder();
  options.oracle = false;
  return score_exports(recording_, truth_, options);
}

double figure(const ScoreReport& report, const std::string& group, const std::string& score,
              const std::string& subject) {
  const Series* series = report.find(group, score, subject);
  EXPECT_NE(series, nullptr) << group << ": " << score << ": " << subject;
  return series == nullptr ? std::numeric_limits<double>::quiet_NaN() : series->summary.mean;
}

}  // namespace touchline::score
