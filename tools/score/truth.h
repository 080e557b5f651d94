// What is true about a recording (formats.md, "Truth"), and the inputs that a hub would have if
// every edge were perfect. Only scorers and tests open it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mesh.h"
#include "shared/image/frame.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/recording.h"

namespace touchline::score {

// A row of truth/people.csv: the ground point under the pelvis, or the ball's centre.
struct TruePerson {
  std::string id;
  std::string team;
  std::string role;
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();

  bool is_ball() const { return role == "ball"; }
};

// A row of truth/joints.csv.
struct TrueJoint {
  std::string person;
  std::string joint;  // "lelbow", "lwrist", "lknee", "lankle", ...
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
};

// The tables of truth/ are held; pictures and meshes are read when asked for.
class Truth {
 public:
  // Fails where the recording has no truth folder or a table in it cannot be read.
  static base::Result<Truth> open(const recording::Recording& recording);

  const std::filesystem::path& root() const { return root_; }

  // The true camera, evidence kLines and covariance 0; none where the truth has no such row.
  // `camera` may be one of the recording's or a virtual one.
  std::optional<geometry::CameraEstimate> camera(const base::CameraId& camera,
                                                 std::int64_t frame) const;
  std::size_t camera_rows(const base::CameraId& camera) const;
  std::vector<std::int64_t> camera_frames(const base::CameraId& camera) const;  // rising
  // Cameras that exist in the truth only, by name.
  const std::vector<base::CameraId>& virtual_cameras() const { return virtual_cameras_; }

  const std::vector<TruePerson>& people(std::int64_t frame) const;
  const std::vector<TrueJoint>& joints(std::int64_t frame) const;
  bool has_people() const { return !people_.empty(); }
  bool has_joints() const { return !joints_.empty(); }
  std::vector<std::int64_t> people_frames() const;  // rising

  // Coverage by people and ball; kNotFound where this frame has none.
  base::Result<image::Image<std::uint8_t>> matte(const base::CameraId& camera,
                                                 std::int64_t frame) const;
  // What a perfect system would render for a virtual camera; not every frame has one.
  base::Result<image::Image<image::Rgb8>> clean(const base::CameraId& camera,
                                                std::int64_t frame) const;
  // All foreground geometry. Not closed.
  base::Result<geometry::Mesh> mesh(std::int64_t frame) const;
  // Frames that have a mesh, or a clean picture of a virtual camera, rising.
  std::vector<std::int64_t> mesh_frames() const;
  std::vector<std::int64_t> clean_frames(const base::CameraId& camera) const;
  std::vector<std::int64_t> matte_frames(const base::CameraId& camera) const;

 private:
  std::filesystem::path root_;
  std::map<base::CameraId, std::map<std::int64_t, geometry::CameraEstimate>> cameras_;
  std::vector<base::CameraId> virtual_cameras_;
  std::map<std::int64_t, std::vector<TruePerson>> people_;
  std::map<std::int64_t, std::vector<TrueJoint>> joints_;
};

// 8-bit grey PNG; kNotFound where there is no such file.
base::Result<image::Image<std::uint8_t>> read_grey_png(const std::filesystem::path& path);
// The alpha channel of an RGBA PNG; kFormat where it has none.
base::Result<image::Image<std::uint8_t>> read_alpha_png(const std::filesystem::path& path);
// RGB PNG (an alpha channel is dropped).
base::Result<image::Image<image::Rgb8>> read_rgb_png(const std::filesystem::path& path);
// Numbers of the files %06d<extension> of a folder, rising; none where there is no folder.
std::vector<std::int64_t> numbered_files(const std::filesystem::path& folder,
                                         const std::string& extension);
// Little-endian binary or ASCII PLY with float x, y, z first in each vertex and triangles.
base::Result<geometry::Mesh> read_ply(const std::filesystem::path& path);
// The same from bytes; `where` names them in errors.
base::Result<geometry::Mesh> parse_ply(std::string_view bytes, const std::string& where);

// Which true person each vertex belongs to: the nearest by plan distance, -1 beyond `reach_m` of
// all. A ball's are those at its radius (0.11 m) from its centre.
std::vector<int> assign_vertices(const geometry::Mesh& mesh, const std::vector<TruePerson>& people,
                                 double reach_m = 1.5);

}  // namespace touchline::score
