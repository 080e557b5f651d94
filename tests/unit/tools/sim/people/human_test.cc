#include "tools/sim/people/human.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "tools/sim/people/decimate.h"
#include "tools/sim/people/figure.h"
#include "tools/sim/people/pose.h"

namespace touchline::sim::people {
namespace {

const std::filesystem::path kAssets = "tools/sim/assets";

const Human& human() {
  static const Human kHuman = *Human::load(kAssets, 11000);
  return kHuman;
}

TEST(Decimate, KeepsASurfaceClosed) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& [i, j, k] : human().triangles) {
    ++edges[{i, j}];
    ++edges[{j, k}];
    ++edges[{k, i}];
  }
  for (const auto& [edge, times] : edges) {
    ASSERT_EQ(times, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1U);
  }
}

TEST(Human, IsAsFineAsAsked) {
  EXPECT_LE(human().triangles.size(), 11000U);
  EXPECT_GE(human().triangles.size(), 10000U);
  EXPECT_EQ(human().canonical.size(), human().triangles.size() / 2 + 2);  // a sphere's genus
}

TEST(Human, WeightsSumToOne) {
  for (const VertexWeights& w : human().weights) {
    float sum = 0;
    for (const float x : w.weight) {
      EXPECT_GE(x, 0);
      sum += x;
    }
    ASSERT_NEAR(sum, 1, 1e-5);
  }
}

TEST(Human, ShapesHaveTheHeightAskedFor) {
  for (const double height : {1.6, 1.8, 2.05}) {
    for (const double weight : {-1.0, 0.0, 1.0}) {
      ShapeSpec spec;
      spec.height_m = height;
      spec.weight = weight;
      const Human::Rest rest = human().shape(spec);
      float low = 9;
      float high = -9;
      for (const auto& p : rest.vertices) {
        low = std::min(low, p.z());
        high = std::max(high, p.z());
      }
      EXPECT_NEAR(low, 0, 1e-4);
      EXPECT_NEAR(high, height, 1e-4);
      EXPECT_GT(rest.heads[index(Bone::kLeftHand)].x(), 0.3);  // X is left
      EXPECT_LT(rest.toe_ends[0].y(), -0.1);                   // -Y is ahead
    }
  }
}

TEST(Human, WeightTellsInTheVolume) {
  const auto volume = [](const ShapeSpec& spec) {
    const Human::Rest rest = human().shape(spec);
    double sum = 0;
    for (const auto& [i, j, k] : human().triangles) {
      sum +=
          static_cast<double>(rest.vertices[i].dot(rest.vertices[j].cross(rest.vertices[k]))) / 6;
    }
    return sum;
  };
  ShapeSpec thin;
  thin.weight = -1;
  ShapeSpec heavy;
  heavy.weight = 1;
  EXPECT_GT(volume(ShapeSpec{}), 0.05);  // triangles face outwards; a man is 50 to 110 litres
  EXPECT_LT(volume(ShapeSpec{}), 0.11);
  EXPECT_LT(volume(thin), volume(ShapeSpec{}));
  EXPECT_GT(volume(heavy), volume(ShapeSpec{}));
}

// With every bone where it is at rest, skinning gives back the rest body.
TEST(Skin, BindPoseIsTheRestMesh) {
  const Human::Rest rest = human().shape(ShapeSpec{});
  const Rig rig(rest);
  std::array<BoneMotion, kBones> still;
  for (std::size_t b = 0; b < kBones; ++b) still[b] = {Eigen::Matrix3f::Identity(), rig.head(b)};
  const auto matrices = skin_matrices(still, rig);
  for (std::size_t v = 0; v < rest.vertices.size(); ++v) {
    ASSERT_LT((skin(rest.vertices[v], human().weights[v], matrices) - rest.vertices[v]).norm(),
              1e-5);
  }
}

TEST(Skin, PelvisAtTheOriginAndLimbsKeepTheirLengths) {
  const Human::Rest rest = human().shape(ShapeSpec{});
  const Rig rig(rest);
  Pose pose;
  for (std::size_t i = 0; i < kNodes; ++i) {
    const float a = 0.3F + 0.1F * static_cast<float>(i);
    pose.node[i] = Eigen::Quaternionf(Eigen::AngleAxisf(
        a, Eigen::Vector3f(1, 0.5F * static_cast<float>(i % 3), -0.4F).normalized()));
  }
  const auto motions = rig.motions(pose);
  EXPECT_LT(motions[0].place.norm(), 1e-6);
  for (std::size_t b = 1; b < kBones; ++b) {
    const auto parent = static_cast<std::size_t>(parent_of(static_cast<Bone>(b)));
    EXPECT_NEAR((motions[b].place - motions[parent].place).norm(),
                (rest.heads[b] - rest.heads[parent]).norm(), 1e-5)
        << b;
    EXPECT_NEAR(motions[b].turn.determinant(), 1, 1e-4);
  }
}

// All limbs straight down: hands under shoulders, feet under hips.
TEST(Rig, StraightPoseHangsLimbsDown) {
  const Rig rig(human().shape(ShapeSpec{}));
  const auto motions = rig.motions(Pose{});
  for (const auto& [from, to] : {std::pair{Bone::kLeftUpperArm1, Bone::kLeftForearm1},
                                 std::pair{Bone::kRightForearm1, Bone::kRightHand},
                                 std::pair{Bone::kLeftThigh1, Bone::kLeftShin},
                                 std::pair{Bone::kRightShin, Bone::kRightFoot}}) {
    const Eigen::Vector3f limb =
        (motions[index(to)].place - motions[index(from)].place).normalized();
    EXPECT_LT(limb.z(), -0.999F);
  }
}

TEST(Figure, ClothesStandOffTheBody) {
  const Figure dressed(human(), ShapeSpec{}, Outfit{});
  const Human::Rest bare = human().shape(ShapeSpec{});
  int out = 0;
  for (std::size_t v = 0; v < bare.vertices.size(); ++v) {
    const Region region =
        region_at(Outfit{}, human().part[v], human().canonical[v], human().along_arm[v]);
    const float far = (dressed.rest()[v] - bare.vertices[v]).norm();
    ASSERT_LT(far, 0.09F);
    if (region == Region::kSkin) {
      ASSERT_LT(far, 1e-6F);
    } else {
      out += far > 0.002F ? 1 : 0;
    }
  }
  EXPECT_GT(out, 1500);
}

TEST(Human, SaysWhichFileIsMissingOrBroken) {
  const auto missing = Human::load("no/such/folder", 11000);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().where.find("base.obj"), std::string::npos);
}

}  // namespace
}  // namespace touchline::sim::people
