#include "tools/score/page/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "shared/image/colour.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/video_reader.h"
#include "tools/draw/canvas.h"
#include "tools/score/page/camera_map.h"
#include "tools/score/page/html_text.h"
#include "tools/score/page/hull_map.h"
#include "tools/score/page/matte_map.h"
#include "tools/score/page/plot.h"
#include "tools/score/page/view_map.h"
#include "tools/score/people_score.h"

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file draws

namespace fs = std::filesystem;

namespace {

constexpr int kWidest = 960;           // of a whole frame in the page, pixels
constexpr int kWidestStrip = 1960;     // of enlarged parts beside one another
constexpr int kTallPerson = 420;       // of a person in a crop, pixels, about
constexpr std::size_t kHullViews = 3;  // cameras that show a person of a hull
constexpr double kReach = 1.5;         // metres within which people are taken for each other

fs::path numbered(const fs::path& folder, std::int64_t frame, const char* extension) {
  return folder / fmt::format("{:06}{}", frame, extension);
}

bool is_person(const std::vector<TruePerson>& people, const std::string& id) {
  return std::any_of(people.begin(), people.end(), [&](const TruePerson& p) { return p.id == id; });
}

class Maker {
 public:
  Maker(const recording::Recording& recording, const Truth& truth, const PageOptions& options,
        pitch::PitchModel pitch)
      : recording_(recording), truth_(truth), options_(options), pitch_(std::move(pitch)) {}

  base::Result<std::vector<Figure>> run(const std::vector<WorstFrame>& frames) {
    figures_.resize(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      Figure& figure = figures_[i];
      figure.frame = frames[i];
      const base::Status planned = plan(figure);
      if (!planned) figure.missing = base::to_string(planned.error());
    }
    for (const recording::CameraEntry& entry : recording_.cameras) decode(entry);
    for (Figure& figure : figures_) {
      if (figure.shots.empty() && figure.missing.empty()) {
        figure.missing = "its frame is not in the video";
      }
    }
    if (!write_error_) return base::fail(write_error_.error());
    return std::move(figures_);
  }

 private:
  using Draw = std::function<base::Status(const Picture& frame)>;

  base::Status plan(Figure& figure) {
    const std::string& group = figure.frame.group;
    if (group == "cameras") return plan_camera(figure);
    if (group == "mattes") return plan_matte(figure);
    if (group == "hull") return plan_hull(figure);
    if (group == "views") return plan_view(figure);
    return plan_people(figure);
  }

  // Calls draw with the camera's frame, later.
  base::Status ask(const std::string& camera, std::int64_t frame, Draw draw) {
    if (recording_.find(base::CameraId{camera}) == nullptr) {
      return base::fail(base::ErrorKind::kNotFound, camera, "is no camera of the recording");
    }
    asked_[camera][frame].push_back(std::move(draw));
    return {};
  }

  void decode(const recording::CameraEntry& entry) {
    const auto asked = asked_.find(entry.id.value);
    if (asked == asked_.end()) return;
    auto reader = recording::VideoReader::open(entry, recording_, 0);
    if (!reader) return;  // the figures say that the frame is missing
    const std::int64_t last = asked->second.rbegin()->first;
    for (std::int64_t number = 0; number <= last; ++number) {
      auto frame = reader->next();
      if (!frame || !*frame) return;
      const auto wanted = asked->second.find(number);
      if (wanted == asked->second.end()) continue;
      const Picture picture = image::to_rgb(**frame);
      for (const Draw& draw : wanted->second) {
        if (const base::Status drawn = draw(picture); !drawn && write_error_) write_error_ = drawn;
      }
    }
  }

  base::Status keep(Figure& figure, const std::string& part, const Picture& picture,
                    const std::string& what) {
    if (picture.empty()) return {};
    const std::string file = fmt::format("pictures/{}-{}.png", figure.frame.id(), part);
    const bool strip = picture.width() > 2 * picture.height();
    if (const auto written =
            write_picture(options_.folder / file, at_most(picture, strip ? kWidestStrip : kWidest));
        !written) {
      return written;
    }
    (part == "ours" || part == "clean" ? figure.blink : figure.shots)
        .push_back({file, {}, what, strip});
    return {};
  }

  std::optional<geometry::CameraEstimate> estimate(const std::string& camera, std::int64_t frame,
                                                   const geometry::CameraModel& size) {
    auto known = tables_.find(camera);
    if (known == tables_.end()) {
      std::map<std::int64_t, recording::CameraRow> rows;
      const auto table =
          recording::read_camera_table(options_.exports / "cameras" / (camera + ".csv"));
      if (table) {
        for (const recording::CameraRow& row : *table) rows[row.frame] = row;
      }
      known = tables_.emplace(camera, std::move(rows)).first;
    }
    const auto row = known->second.find(frame);
    if (row == known->second.end()) return std::nullopt;
    geometry::CameraEstimate out;
    out.model = row->second.model;
    out.model.width = size.width;
    out.model.height = size.height;
    out.cam_from_world = row->second.cam_from_world;
    out.evidence = row->second.report ? row->second.report->state : geometry::Evidence::kLines;
    if (out.lost()) return std::nullopt;
    return out;
  }

  base::Status plan_camera(Figure& figure) {
    const WorstFrame& at = figure.frame;
    const auto truth = truth_.camera(base::CameraId{at.subject}, at.frame);
    if (!truth) {
      return base::fail(base::ErrorKind::kNotFound, at.subject, "no true camera at this frame");
    }
    return ask(
        at.subject, at.frame,
        [this, &figure, truth = *truth,
         found = estimate(at.subject, at.frame, truth->model)](const Picture& frame) {
          const CameraMap map = camera_map(frame, truth, found, pitch_);
          if (!found) return keep(figure, "whole", map.whole, "No estimate. True markings green.");
          const auto done = keep(figure, "whole", map.whole,
                                 fmt::format("Turf points, true to estimated, {:g} times as long. "
                                             "Markings: true green, estimated orange.",
                                             map.exaggeration));
          if (!done) return done;
          return keep(
              figure, "zoom", map.zoom,
              fmt::format("Six times: where a marking is farthest off, {:.2f} px.", map.zoom_px));
        });
  }

  // The true and the found matte of a camera.
  struct Mattes {
    Mask truth, found;
  };
  base::Result<std::shared_ptr<const Mattes>> mattes(const std::string& camera,
                                                     std::int64_t frame) const {
    auto truth = truth_.matte(base::CameraId{camera}, frame);
    if (!truth) return base::fail(truth.error());
    auto found = read_grey_png(numbered(options_.exports / "mattes" / camera, frame, ".png"));
    if (!found) return base::fail(found.error());
    if (found->width() != truth->width() || found->height() != truth->height()) {
      return base::fail(base::ErrorKind::kFormat, camera, "mattes of two sizes");
    }
    return std::make_shared<const Mattes>(Mattes{std::move(*truth), std::move(*found)});
  }

  base::Status draw_matte(Figure& figure, const std::string& camera,
                          std::shared_ptr<const Mattes> both, const image::Rect& round) {
    return ask(
        camera, figure.frame.frame,
        [this, &figure, camera, both = std::move(both), round](const Picture& frame) {
          if (frame.width() != both->truth.width() || frame.height() != both->truth.height()) {
            figure.missing = "its frame has another size than its matte";
            return base::Status{};
          }
          const MatteMap map = matte_map(frame, both->truth, both->found, 2, round);
          for (std::size_t i = 0; i < map.zooms.size(); ++i) {
            const auto done =
                keep(figure, fmt::format("zoom{}", i + 1), map.zooms[i],
                     round.empty() ? std::string("Enlarged: where errors are densest.") : camera);
            if (!done) return done;
          }
          return keep(figure, "whole", map.whole,
                      fmt::format("{}: missing coverage red, extra coverage blue.", camera));
        });
  }

  base::Status plan_matte(Figure& figure) {
    const WorstFrame& at = figure.frame;
    if (is_person(truth_.people(at.frame), at.subject)) return plan_matte_of_person(figure);
    const auto both = mattes(at.subject, at.frame);
    if (!both) return base::fail(both.error());
    return draw_matte(figure, at.subject, *both, {});
  }

  // In the camera that misses most of the person.
  base::Status plan_matte_of_person(Figure& figure) {
    const WorstFrame& at = figure.frame;
    Eigen::Vector3f foot = Eigen::Vector3f::Zero();
    for (const TruePerson& p : truth_.people(at.frame)) {
      if (p.id == at.subject) foot = p.position_in_world.cast<float>();
    }
    std::string worst;
    std::shared_ptr<const Mattes> shown;
    image::Rect round;
    double most = -1;
    for (const recording::CameraEntry& entry : recording_.cameras) {
      const auto truth = truth_.camera(entry.id, at.frame);
      if (!truth) continue;
      const image::Rect window =
          window_round(*truth, {foot, foot + Eigen::Vector3f(0, 0, 1.8F)}, 0.3);
      if (window.empty()) continue;
      const auto both = mattes(entry.id.value, at.frame);
      if (!both) continue;
      double missing = 0;
      double all = 1;
      for (int y = window.y; y < window.y + window.height; ++y) {
        for (int x = window.x; x < window.x + window.width; ++x) {
          const bool is = (*both)->truth(x, y) >= 128;
          all += is;
          missing += is && (*both)->found(x, y) < 128;
        }
      }
      if (missing / all <= most) continue;
      most = missing / all;
      worst = entry.id.value;
      shown = *both;
      round = window;
    }
    if (!shown) return base::fail(base::ErrorKind::kNotFound, at.subject, "no camera shows it");
    return draw_matte(figure, worst, std::move(shown), round);
  }

  struct Surfaces {
    geometry::Mesh hull, truth;
    HullFaults faults;
    std::vector<TruePerson> people;
    std::vector<int> owner;  // of the true vertices
  };

  base::Result<std::shared_ptr<const Surfaces>> surfaces(std::int64_t frame) {
    const auto known = surfaces_.find(frame);
    if (known != surfaces_.end()) return known->second;
    auto made = std::make_shared<Surfaces>();
    auto hull = read_ply(numbered(options_.exports / "hull", frame, ".ply"));
    if (!hull) return base::fail(hull.error());
    auto mesh = truth_.mesh(frame);
    if (!mesh) return base::fail(mesh.error());
    made->hull = std::move(*hull);
    made->truth = std::move(*mesh);
    made->people = truth_.people(frame);
    made->owner = assign_vertices(made->truth, made->people);
    made->faults = find_faults(made->hull, made->truth, options_.voxel_m);
    surfaces_[frame] = made;
    return std::shared_ptr<const Surfaces>(made);
  }

  base::Status plan_hull(Figure& figure) {
    const WorstFrame& at = figure.frame;
    const auto shape = surfaces(at.frame);
    if (!shape) return base::fail(shape.error());
    struct View {
      std::string camera;
      geometry::CameraEstimate truth;
      image::Rect window;
      int zoom = 1;
      double merit = 0;
    };
    std::vector<View> views;
    std::vector<Eigen::Vector3f> points;
    const auto person = std::find_if((*shape)->people.begin(), (*shape)->people.end(),
                                     [&](const TruePerson& p) { return p.id == at.subject; });
    const bool one = person != (*shape)->people.end();
    const auto number = static_cast<int>(person - (*shape)->people.begin());
    for (std::size_t i = 0; i < (*shape)->truth.vertices.size(); ++i) {
      if (one && (*shape)->owner[i] == number) points.push_back((*shape)->truth.vertices[i]);
    }
    for (const recording::CameraEntry& entry : recording_.cameras) {
      const auto truth = truth_.camera(entry.id, at.frame);
      if (!truth) continue;
      View view{entry.id.value, *truth, {0, 0, entry.width, entry.height}, 1, 0};
      if (one) {
        view.window = window_round(*truth, points);
        if (view.window.empty()) continue;
        view.zoom = std::clamp(kTallPerson / std::max(1, view.window.height), 1, 8);
        view.merit = view.window.height;
      } else {
        for (const TruePerson& p : (*shape)->people) {
          const auto pixel = geometry::project(*truth, p.position_in_world);
          view.merit += pixel && truth->model.sees(*pixel);
        }
      }
      views.push_back(std::move(view));
    }
    if (views.empty()) {
      return base::fail(base::ErrorKind::kNotFound, at.subject, "no camera shows it");
    }
    std::stable_sort(views.begin(), views.end(),
                     [](const View& a, const View& b) { return a.merit > b.merit; });
    if (views.size() > (one ? kHullViews : 1)) views.resize(one ? kHullViews : 1);
    for (const View& view : views) {
      const auto asked =
          ask(view.camera, at.frame, [this, &figure, view, shape = *shape](const Picture& frame) {
            const Picture map = hull_map(frame, view.truth, shape->truth, shape->hull,
                                         shape->faults, view.window, view.zoom);
            return keep(figure, view.camera, map,
                        fmt::format("{}: true outline green, hull orange, {} true vertices outside "
                                    "all hulls red, phantoms ({}) blue.",
                                    view.camera, shape->faults.outside.size(),
                                    shape->faults.phantoms.size()));
          });
      if (!asked) return asked;
    }
    return {};
  }

  base::Status plan_view(Figure& figure) {
    const WorstFrame& at = figure.frame;
    const auto& cameras = truth_.virtual_cameras();
    const bool person = is_person(truth_.people(at.frame), at.subject);
    const auto camera = std::find_if(cameras.begin(), cameras.end(), [&](const base::CameraId& c) {
      const auto frames = truth_.clean_frames(c);
      return (person || c.value == at.subject) &&
             std::find(frames.begin(), frames.end(), at.frame) != frames.end();
    });
    if (camera == cameras.end()) {
      return base::fail(base::ErrorKind::kNotFound, at.subject, "no clean picture of this frame");
    }
    const auto clean = truth_.clean(*camera, at.frame);
    if (!clean) return base::fail(clean.error());
    const auto ours =
        read_rgb_png(numbered(options_.exports / "renders" / camera->value, at.frame, ".png"));
    if (!ours) return base::fail(ours.error());
    if (ours->width() != clean->width() || ours->height() != clean->height()) {
      return base::fail(base::ErrorKind::kFormat, camera->value, "pictures of two sizes");
    }
    std::optional<Mask> matte;
    if (auto read = truth_.matte(*camera, at.frame)) matte = std::move(*read);
    image::Rect round;
    if (const auto truth = truth_.camera(*camera, at.frame); person && truth) {
      for (const TruePerson& p : truth_.people(at.frame)) {
        if (p.id != at.subject) continue;
        const Eigen::Vector3f foot = p.position_in_world.cast<float>();
        round = window_round(*truth, {foot, foot + Eigen::Vector3f(0, 0, 1.8F)}, 0.4);
      }
    }
    const ViewMap map = view_map(*clean, *ours, matte, round);
    for (const auto& [part, picture, what] :
         {std::tuple{"zoom", &map.zoom, "Where people differ most."},
          std::tuple{"difference", &map.difference,
                     "Difference, brightest at 64 of 255 codes and more."},
          std::tuple{"ours", &*ours, "ours"}, std::tuple{"clean", &*clean, "clean"}}) {
      if (person && picture != &map.zoom) continue;
      if (const auto done = keep(figure, part, *picture, what); !done) return done;
    }
    return {};
  }

  base::Status plan_people(Figure& figure) {
    const WorstFrame& at = figure.frame;
    if (told_.empty()) {
      auto read = read_people(options_.exports / "people" / "people.csv");
      if (!read) return base::fail(read.error());
      told_ = std::move(*read);
    }
    const auto plan_of = [](const std::vector<TruePerson>& people) {
      std::vector<PlanPerson> out;
      for (const TruePerson& p : people) {
        out.push_back({p.id, p.position_in_world.x(), p.position_in_world.y(), p.is_ball()});
      }
      return out;
    };
    figure.shots.push_back(
        {{},
         plan_svg(plan_of(truth_.people(at.frame)), plan_of(told_[at.frame]), kReach,
                  pitch_.length_m / 2 + pitch_.in_goal_m, pitch_.width_m / 2),
         "From above: true people are rings, told ones dots; a red ring has nobody told within "
         "1.5 m.",
         true});
    return {};
  }

  const recording::Recording& recording_;
  const Truth& truth_;
  const PageOptions& options_;
  pitch::PitchModel pitch_;
  std::vector<Figure> figures_;  // not resized once planned: drawings refer to them
  std::map<std::string, std::map<std::int64_t, std::vector<Draw>>> asked_;
  std::map<std::string, std::map<std::int64_t, recording::CameraRow>> tables_;
  std::map<std::int64_t, std::shared_ptr<const Surfaces>> surfaces_;
  std::map<std::int64_t, std::vector<TruePerson>> told_;
  base::Status write_error_;
};

}  // namespace

base::Result<std::vector<Figure>> make_figures(const std::vector<WorstFrame>& frames,
                                               const recording::Recording& recording,
                                               const Truth& truth, const PageOptions& options) {
  auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  std::error_code error;
  fs::create_directories(options.folder / "pictures", error);
  if (error) {
    return base::fail(base::ErrorKind::kIo, (options.folder / "pictures").string(), error.message(),
                      "check the folder");
  }
  return Maker(recording, truth, options, std::move(*pitch)).run(frames);
}

}  // namespace touchline::score::page
