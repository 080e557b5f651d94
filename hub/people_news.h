// Tells units that do not know where they look where other cameras see people stand. Nothing is
// decoded, and nothing said, while every camera knows.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <thread>

#include "shared/base/bounded_queue.h"
#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"
#include "shared/wire/messages.h"

namespace touchline::hub {

class PeopleNews {
 public:
  // `send` is called from a thread of this object, until it is destroyed.
  PeopleNews(pitch::PitchModel pitch, std::function<void(const wire::PeopleMessage&)> send);
  ~PeopleNews();
  PeopleNews(const PeopleNews&) = delete;
  PeopleNews& operator=(const PeopleNews&) = delete;

  // Every view as it comes; returns at once. A view that does not decode says nothing.
  void see(const codec::EncodedView& view);

 private:
  struct Camera {
    bool lost = false;
    std::int64_t told_ns = 0;  // media time of its last news
    bool told = false;
  };

  void tell(const codec::EncodedView& view) const;

  const pitch::PitchModel pitch_;
  const std::function<void(const wire::PeopleMessage&)> send_;
  std::map<std::string, Camera> cameras_;
  base::BoundedQueue<codec::EncodedView> queue_;
  std::jthread thread_;  // last: it uses the rest
};

}  // namespace touchline::hub
