#include "tools/sim/people/asset_files.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tools/sim/people/pose.h"

namespace touchline::sim::people {
namespace {

TEST(ObjFile, ReadsTheBodyAloneAndSplitsPolygons) {
  const auto file = parse_obj(
      "# a mesh\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng body\nf 1/1 2/2 3/3 4/4\ng helper\nf 1 2 "
      "3\n",
      "a.obj");
  ASSERT_TRUE(file) << base::to_string(file.error());
  EXPECT_EQ(file->vertices.size(), 4U);
  ASSERT_EQ(file->triangles.size(), 2U);
  EXPECT_EQ(file->triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST(ObjFile, RefusesWithTheLine) {
  const auto bad = parse_obj("v 0 0 0\nv 1 nan 0\n", "a.obj");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().where, "a.obj:2");
  EXPECT_FALSE(parse_obj("v 0 0 0\ng body\nf 1 2 3\n", "a.obj"));
  EXPECT_FALSE(parse_obj("v 0 0 0\ng body\nf 0 1 1\n", "a.obj"));
  EXPECT_FALSE(parse_obj("v 0 0\n", "a.obj"));
  EXPECT_FALSE(parse_obj("", "a.obj"));
}

TEST(TargetFile, ReadsMovesAndRefusesOthers) {
  const auto file = parse_target("# x\n0 .012 1.544 -.062\n12 1 2 3\n", "a.target");
  ASSERT_TRUE(file);
  ASSERT_EQ(file->size(), 2U);
  EXPECT_FLOAT_EQ((*file)[0].second.y(), 1.544F);
  EXPECT_EQ((*file)[1].first, 12U);
  EXPECT_FALSE(parse_target("x 1 2 3\n", "a.target"));
  EXPECT_FALSE(parse_target("1 2 3\n", "a.target"));
  EXPECT_FALSE(parse_target("-1 0 2 3\n", "a.target"));
}

TEST(SkeletonFile, OrdersParentsFirst) {
  const auto file = parse_skeleton(
      R"({"bones":{"a":{"head":"h","tail":"t","parent":"z"},"z":{"head":"h","tail":"t","parent":null}},
          "joints":{"h":[1,2],"t":[3]}})",
      "s");
  ASSERT_TRUE(file) << base::to_string(file.error());
  ASSERT_EQ(file->bones.size(), 2U);
  EXPECT_EQ(file->bones[0].name, "z");
  EXPECT_EQ(file->bones[1].parent, 0);
}

TEST(SkeletonFile, RefusesRingsAndGaps) {
  EXPECT_FALSE(parse_skeleton(
      R"({"bones":{"a":{"head":"h","tail":"t","parent":"a"}},"joints":{"h":[1],"t":[3]}})", "s"));
  EXPECT_FALSE(
      parse_skeleton(R"({"bones":{"a":{"head":"h","tail":"t"}},"joints":{"h":[1]}})", "s"));
  EXPECT_FALSE(parse_skeleton(R"({"bones":{}})", "s"));
  EXPECT_FALSE(parse_skeleton("[[[", "s"));
  EXPECT_FALSE(parse_skeleton(std::string(100000, '['), "s"));
}

TEST(WeightsFile, KeepsWhatIsOverZero) {
  const auto file = parse_weights(R"({"weights":{"a":[[3,0.5],[4,0]],"b":[]}})", "w");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->at("a").size(), 1U);
  EXPECT_FALSE(parse_weights(R"({"weights":{"a":[[3,-0.5]]}})", "w"));
  EXPECT_FALSE(parse_weights(R"({"weights":{"a":[[3]]}})", "w"));
  EXPECT_FALSE(parse_weights(R"({"weights":[]})", "w"));
}

std::string clip_text() {
  std::string text = "player,0,0,0,0,10,0,-1,0.5\n";
  for (const char* node :
       {"body", "middle", "neck", "left_shoulder", "left_elbow", "right_shoulder", "right_elbow",
        "left_thigh", "left_knee", "left_ankle", "right_thigh", "right_knee", "right_ankle"}) {
    text += std::string(node) + ",0,0,0,0,1,10,1,0,0,0\n";
  }
  return text + "extension,football,4,0.1,-0.5,0.11\n<type>\n shot\n</type>\n";
}

TEST(ClipFile, ReadsKeysAndTheBall) {
  const auto file = parse_clip(clip_text(), "c");
  ASSERT_TRUE(file) << base::to_string(file.error());
  EXPECT_EQ(file->frames, 10);
  ASSERT_TRUE(file->ball);
  EXPECT_EQ(file->ball->first, 4);
  const Clip clip(*file);
  EXPECT_DOUBLE_EQ(clip.seconds(), 0.1);
  EXPECT_NEAR(clip.at(0.05).root.y(), -0.5, 1e-5);
  // Half of a half turn about X.
  EXPECT_NEAR(std::abs(clip.at(0.05).node[0].x()), std::sqrt(0.5), 1e-5);
  EXPECT_NEAR(clip.at(9).root.y(), -1, 1e-6);
}

TEST(ClipFile, Refuses) {
  EXPECT_FALSE(parse_clip("", "c"));
  EXPECT_FALSE(parse_clip("player,0,0,0\n", "c"));
  EXPECT_FALSE(parse_clip("player,5,0,0,0\n", "c"));
  EXPECT_FALSE(parse_clip("player,0,0,0,0,0,0,0,0\n", "c"));
  EXPECT_FALSE(parse_clip("player,0,0,0,0,10,0,0,0\nbody,0,0,0,0,0\n", "c"));
  EXPECT_FALSE(parse_clip("player,0,0,0,0,10,0,0,0\n", "c"));
}

TEST(Pose, MirrorTwiceIsItself) {
  const auto file = parse_clip(clip_text(), "c");
  ASSERT_TRUE(file);
  Pose pose = Clip(*file).at(0.03);
  pose.node[3] = Eigen::Quaternionf(0.8F, 0.3F, -0.4F, 0.2F).normalized();
  const Pose back = mirrored(mirrored(pose));
  for (std::size_t i = 0; i < kNodes; ++i) {
    EXPECT_LT((back.node[i].coeffs() - pose.node[i].coeffs()).norm(), 1e-6);
  }
  EXPECT_GT((mirrored(pose).node[3].coeffs() - pose.node[3].coeffs()).norm(), 0.1);
}

}  // namespace
}  // namespace touchline::sim::people
