#include "hub/shot_pipeline.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "hub/render/colour_reference.h"

namespace touchline::hub {
namespace {

class SecondsInto {
 public:
  explicit SecondsInto(double& total) : total_(total), start_(std::chrono::steady_clock::now()) {}
  SecondsInto(const SecondsInto&) = delete;
  SecondsInto& operator=(const SecondsInto&) = delete;
  ~SecondsInto() {
    total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  double& total_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace

struct Shot::Impl {
  ShotOptions options;
  session::SessionReader session;
  pitch::PitchModel pitch;
  std::vector<std::int64_t> frames;
  std::map<std::int64_t, std::size_t> index_of_frame;
  // Made when the first picture is asked for: exports of cameras, mattes and hulls need none.
  std::optional<render::Renderer> renderer;
  std::shared_ptr<const Instant> last;
  ShotTimes times;

  base::Status prepare_renderer() {
    if (renderer) return {};
    const SecondsInto timer(times.open_s);
    auto plates = session.plates();
    if (!plates) return base::fail(plates.error());
    const render::ColourReference colour =
        render::estimate_colour_reference(pitch, *plates, options.colour);
    auto made = render::Renderer::make(pitch, *plates, colour, options.render);
    if (!made) return base::fail(made.error());
    renderer.emplace(std::move(*made));
    return {};
  }
};

Shot::Shot(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Shot::Shot(Shot&&) noexcept = default;
Shot& Shot::operator=(Shot&&) noexcept = default;
Shot::~Shot() = default;

base::Result<Shot> Shot::open(const std::filesystem::path& session_folder,
                              const ShotOptions& options) {
  for (const base::Status& part :
       {options.hull.validate(), options.render.validate(), options.colour.validate()}) {
    if (!part) return base::fail(part.error());
  }
  auto session = session::SessionReader::open(session_folder, options.limits);
  if (!session) return base::fail(session.error());
  auto pitch = pitch::make_pitch(session->info().sport, session->info().sizes);
  if (!pitch) return base::fail(pitch.error());
  auto impl = std::unique_ptr<Impl>(
      new Impl{options, std::move(*session), std::move(*pitch), {}, {}, {}, {}, {}});
  for (std::size_t i = 0; i < impl->session.instants().size(); ++i) {
    const std::int64_t frame = impl->session.frame_number(i);
    impl->frames.push_back(frame);
    impl->index_of_frame[frame] = i;
  }
  return Shot(std::move(impl));
}

const session::SessionReader& Shot::session() const { return impl_->session; }
const pitch::PitchModel& Shot::pitch() const { return impl_->pitch; }
const std::vector<std::int64_t>& Shot::frames() const { return impl_->frames; }
ShotTimes Shot::times() const { return impl_->times; }

base::Result<decode::DecodedSet> Shot::decode(std::int64_t frame) {
  const SecondsInto timer(impl_->times.decode_s);
  const auto found = impl_->index_of_frame.find(frame);
  if (found == impl_->index_of_frame.end()) {
    const std::string there = impl_->frames.empty()
                                  ? "the session has none"
                                  : fmt::format("the session has frames {} to {}",
                                                impl_->frames.front(), impl_->frames.back());
    return base::fail(base::ErrorKind::kNotFound, fmt::format("frame {}", frame),
                      "it is not in the session", there);
  }
  auto set = impl_->session.frame_set(found->second);
  if (!set) return base::fail(set.error());
  return decode::decode_set(*set, impl_->options.limits);
}

base::Result<std::shared_ptr<const Instant>> Shot::instant(std::int64_t frame) {
  if (impl_->last && impl_->last->frame == frame) return impl_->last;
  auto set = decode(frame);
  if (!set) return base::fail(set.error());
  auto made = std::make_shared<Instant>();
  made->frame = frame;
  made->set = std::move(*set);
  {
    const SecondsInto timer(impl_->times.hull_s);
    made->hull = hull::carve(made->set.views, impl_->pitch, impl_->options.hull).hull;
  }
  impl_->last = made;
  return impl_->last;
}

base::Result<render::RenderResult> Shot::render(std::int64_t frame,
                                                const geometry::CameraEstimate& virtual_camera,
                                                render::Mode mode, bool foreground) {
  if (base::Status status = impl_->prepare_renderer(); !status) return base::fail(status.error());
  auto now = instant(frame);
  if (!now) return base::fail(now.error());
  const SecondsInto timer(impl_->times.render_s);
  ++impl_->times.pictures;
  const Instant& i = **now;
  return foreground ? impl_->renderer->render_foreground(i.set.views, i.hull, virtual_camera, mode)
                    : impl_->renderer->render(i.set.views, i.hull, virtual_camera, mode);
}

}  // namespace touchline::hub
