// A head whose picture shows people alone is found by those whom other cameras see.
#include "edge/peer_follower.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/unit/edge/pipeline/sample_take.h"

namespace touchline::edge {
namespace {

constexpr int kSeen = 7;  // frames of the ten before turf and hoardings go

std::vector<calibrate::StandingPlace> people_at(std::size_t frame) {
  std::vector<calibrate::StandingPlace> out;
  std::ifstream file("tests/data/sample/truth/people.csv");
  std::string row;
  std::getline(file, row);
  while (std::getline(file, row)) {
    std::stringstream cells(row);
    std::vector<std::string> cell;
    for (std::string one; std::getline(cells, one, ',');) cell.push_back(one);
    if (cell.size() < 6 || std::stoul(cell[0]) != frame || cell[3] == "ball") continue;
    out.push_back({{std::stod(cell[4]), std::stod(cell[5])}, 0.1});
  }
  return out;
}

// The same people before turf without a line, a mark or a board.
image::Frame people_alone(const image::Frame& frame, std::size_t index) {
  image::Frame out = frame;
  const cv::Mat people =
      cv::imread("tests/data/sample/truth/m1/matte/00000" + std::to_string(index) + ".png",
                 cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(people.cols, frame.width());
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      if (people.at<std::uint8_t>(y, x) > 100) continue;
      out.planes[0](x, y) = 350;
      out.planes[1](x >> shift.x, y >> shift.y) = 430;
      out.planes[2](x >> shift.x, y >> shift.y) = 440;
    }
  }
  return out;
}

class PeopleAlone : public SampleTake {
 protected:
  void SetUp() override {
    load([](image::Frame frame, std::size_t index) {
      return index < kSeen ? std::move(frame) : people_alone(frame, index);
    });
    options_.peers.period_s = 0;
    options_.peers.most_px = 15;
  }

  std::vector<codec::EncodedView> run(bool told, ChainReport& report) {
    return play(nullptr, report, [&](FrameChain& chain, std::size_t i) {
      const base::FrameStamp& stamp = frames_[i]->stamp;
      if (told) chain.hear({base::CameraId{"m2"}, stamp.media_time, stamp.domain, people_at(i)});
    });
  }
};

TEST_F(PeopleAlone, AreEnoughWhereOtherCamerasSeeThem) {
  ChainReport report;
  const auto views = run(true, report);
  ASSERT_EQ(views.size(), frames_.size());
  double most_px = 0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const bool seen = k < kSeen;
    if (!seen) most_px = std::max(most_px, apart_px(views[k].estimate, truth_[k]));
    EXPECT_EQ(views[k].estimate.evidence,
              seen ? geometry::Evidence::kLines : geometry::Evidence::kPeers)
        << k;
    EXPECT_LT(apart_px(views[k].estimate, truth_[k]), seen ? 2 : 25) << k;
  }
  RecordProperty("most_px", std::to_string(most_px));
  EXPECT_EQ(report.frames_by_peers, frames_.size() - kSeen);
  EXPECT_EQ(report.frames_lost, 0u);
}

TEST_F(PeopleAlone, SayNothingWhereNobodyTells) {
  ChainReport report;
  const auto views = run(false, report);
  ASSERT_EQ(views.size(), frames_.size());
  EXPECT_TRUE(views.back().estimate.lost());
  EXPECT_EQ(report.frames_by_peers, 0u);
}

TEST_F(PeopleAlone, SeenLongAgoOrByAnotherClockSayNothing) {
  auto pitch = pitch::make_pitch(setup_.sport, setup_.sizes);
  ASSERT_TRUE(pitch.has_value());
  geometry::Mount mount;
  mount.width = frames_.back()->width();
  mount.height = frames_.back()->height();
  mount.cx = 0.5 * (mount.width - 1);
  mount.cy = 0.5 * (mount.height - 1);
  mount.position_in_world = geometry::origin(truth_.back().cam_from_world);
  const base::FrameStamp stamp = frames_.back()->stamp;
  const auto found_by = [&](PeopleSeen seen) {
    PeerFollower follower(options_.peers);
    geometry::CameraEstimate last;
    last.model = truth_.back().model;
    last.cam_from_world = truth_.back().cam_from_world;
    last.covariance(0, 0) = last.covariance(1, 1) = 1e-6;
    last.covariance(3, 3) = 1e-4;
    last.evidence = geometry::Evidence::kLines;
    follower.learn(*frames_.back(), last);
    follower.hear(std::move(seen));
    return follower.find(*frames_.back(), *pitch, mount).evidence;
  };
  const auto people = people_at(frames_.size() - 1);
  EXPECT_EQ(found_by({{"m2"}, stamp.media_time, stamp.domain, people}), geometry::Evidence::kPeers);
  EXPECT_EQ(found_by({{"m2"}, {stamp.media_time.ns - 2'000'000'000}, stamp.domain, people}),
            geometry::Evidence::kLost);
  EXPECT_EQ(found_by({{"m2"}, stamp.media_time, base::ClockDomain::kNtp, people}),
            geometry::Evidence::kLost);
}

TEST(PeerOptions, ValidateNamesTheField) {
  PeerOptions options;
  EXPECT_TRUE(options.validate().has_value());
  options.oldest_s = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_EQ(options.validate().error().where, "peers.oldest_s");
}

}  // namespace
}  // namespace touchline::edge
