#include "edge/take_pictures.h"

#include <gtest/gtest.h>

namespace touchline::edge {
namespace {

// Small frames, numbered; an error behind the last where one is asked for.
class Counted final : public capture::FrameSource {
 public:
  Counted(int frames, bool broken) : frames_(frames), broken_(broken) {}
  base::Result<std::optional<image::FramePtr>> next(std::stop_token) override {
    if (at_ == frames_) {
      if (broken_) return base::fail(base::Error{});
      return std::optional<image::FramePtr>{};
    }
    auto frame = std::make_shared<image::Frame>();
    frame->id.sequence = static_cast<std::uint64_t>(at_++);
    frame->planes[0] = image::Image<std::uint16_t>(1024, 512);  // 1 MiB
    return std::optional<image::FramePtr>(std::move(frame));
  }

 private:
  int frames_;
  bool broken_;
  int at_ = 0;
};

TEST(TakePictures, AreSpreadEvenlyFromTheFirstOn) {
  for (const int frames : {1, 2, 7, 16, 17, 100, 333}) {
    Counted source(frames, false);
    TakePicturesOptions options;
    options.pictures = 16;
    const auto taken = take_pictures(source, {25, 1}, options, {});
    ASSERT_FALSE(taken.empty());
    EXPECT_EQ(taken[0]->id.sequence, 0u);
    EXPECT_LE(taken.size(), 16u);
    EXPECT_GE(static_cast<int>(taken.size()), std::min(frames, 8));
    const std::uint64_t apart = taken.size() > 1 ? taken[1]->id.sequence : 1;
    for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_EQ(taken[i]->id.sequence, i * apart);
    EXPECT_LT(static_cast<std::uint64_t>(frames) - taken.back()->id.sequence, apart + 1);
  }
}

TEST(TakePictures, KeepToMemoryAndTime) {
  Counted source(1000, false);
  TakePicturesOptions options;
  options.mib = 16;
  options.look_s = 10;
  const auto taken = take_pictures(source, {25, 1}, options, {});
  EXPECT_LE(taken.size(), 16u);
  EXPECT_LT(taken.back()->id.sequence, 250u);
}

TEST(TakePictures, EndBeforeAFrameThatCannotBeRead) {
  Counted source(5, true);
  EXPECT_EQ(take_pictures(source, {25, 1}, {}, {}).size(), 5u);
}

TEST(TakePicturesOptions, NamesTheFieldThatIsOutOfBounds) {
  TakePicturesOptions options;
  options.mib = 1;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(base::to_string(status.error()).find("mib"), std::string::npos);
}

}  // namespace
}  // namespace touchline::edge
