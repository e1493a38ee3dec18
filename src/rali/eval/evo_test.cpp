#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/eval/alignment.hpp"
#include "rali/eval/errors.hpp"

// Numbers of evo (github.com/MichaelGrupp/evo, commit 26d0953) for the same poses:
// evo_ape -a, and evo_rpe -u m --pairs_from_reference with and without --all_pairs.

namespace rali::eval {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSame = 1e-9;

SE3 truth(int i) {
  return {geometry::rotation_from_rpy(0.02 * std::sin(0.1 * i), 0.1 * std::sin(0.03 * i), 0.05 * i),
          Vec3(10.0 * std::sin(0.04 * i), 5.0 * std::sin(0.08 * i), 0.3 * std::cos(0.02 * i))};
}

SE3 estimate(int i) {
  const SE3 frame{geometry::rotation_from_rpy(0.01, -0.02, 0.7), Vec3(3.0, -2.0, 0.5)};
  const SE3 off{
      geometry::rotation_from_rpy(0.01 * std::sin(3.0 * i), 0.02 * std::sin(5.0 * i),
                                  0.03 * std::sin(2.0 * i)),
      Vec3(0.05 * std::sin(7.0 * i), 0.04 * std::cos(3.0 * i), 0.03 * std::sin(11.0 * i))};
  return frame * truth(i) * off;
}

PoseList truth_list(int n) {
  PoseList list;
  for (int i = 0; i < n; ++i) list.push_back({Time::from_s(0.1 * i), truth(i)});
  return list;
}

/// Stamps off by up to 4 ms, each tenth by 16 ms or more.
PoseList estimate_list() {
  PoseList list;
  for (int i = 0; i < 120; ++i) {
    const double t_s = 0.1 * i + 0.004 * std::sin(i) + (i % 10 == 0 ? 0.02 : 0.0);
    list.push_back({Time::from_s(t_s), estimate(i)});
  }
  return list;
}

struct Expected {
  std::size_t count;
  double rmse, max;
};

void expect_rpe(const PairList& pairs, double distance_m, bool all_pairs, Expected m,
                Expected deg) {
  const auto errors = relative_errors(pairs, {distance_m, all_pairs, 0.1, false});
  ASSERT_EQ(errors.size(), m.count);
  EXPECT_NEAR(translation_statistics(errors).rmse, m.rmse, kSame);
  EXPECT_NEAR(translation_statistics(errors).max, m.max, kSame);
  EXPECT_NEAR(rotation_statistics(errors).rmse / kDegree, deg.rmse, 1e-7);
  EXPECT_NEAR(rotation_statistics(errors).max / kDegree, deg.max, 1e-7);
}

TEST(Evo, absolute_errors_are_those_of_evo_ape) {
  const auto found = associate(estimate_list(), truth_list(150), {});
  ASSERT_TRUE(found);
  ASSERT_EQ(found->pairs.size(), 108U);
  const auto T = align(found->pairs, Alignment::kSe3);
  ASSERT_TRUE(T);
  const auto errors = absolute_errors(found->pairs, *T);
  const Statistics m = translation_statistics(errors);
  EXPECT_NEAR(m.rmse, 0.0505264822991801, kSame);
  EXPECT_NEAR(m.mean, 0.0491587628726224, kSame);
  EXPECT_NEAR(m.median, 0.0519228494988801, kSame);
  EXPECT_NEAR(m.std, 0.0116765340046886, kSame);
  EXPECT_NEAR(m.min, 0.0274378956590549, kSame);
  EXPECT_NEAR(m.max, 0.064893705950812, kSame);
  EXPECT_NEAR(m.sse, 0.275715944661171, kSame);
  const Statistics r = rotation_statistics(errors);
  EXPECT_NEAR(r.rmse / kDegree, 1.51666005002933, 1e-7);
  EXPECT_NEAR(r.max / kDegree, 2.03439947972344, 1e-7);
}

TEST(Evo, relative_errors_are_those_of_evo_rpe) {
  const auto found = associate(estimate_list(), truth_list(150), {});
  ASSERT_TRUE(found);
  const PairList& p = found->pairs;
  expect_rpe(p, 1.0, true, {50, 0.0808845263542688, 0.12748571957118},
             {50, 2.08590098021901, 3.79881451966201});
  expect_rpe(p, 5.0, true, {96, 0.133512875894073, 0.217017650818912},
             {96, 2.02941295072544, 3.91661769849727});
  expect_rpe(p, 1.0, false, {36, 0.0891007305365473, 0.129258002123739},
             {36, 2.02651145386155, 3.20571188564989});
  expect_rpe(p, 5.0, false, {7, 0.136673883037164, 0.179351597651146},
             {7, 2.53696216332784, 3.91643063806265});
}

TEST(Evo, pairs_from_a_shorter_ground_truth_as_evo_does) {
  const auto found = associate(estimate_list(), truth_list(100), {});
  ASSERT_TRUE(found);
  ASSERT_EQ(found->pairs.size(), 90U);
  const auto T = align(found->pairs, Alignment::kSe3);
  ASSERT_TRUE(T);
  EXPECT_NEAR(translation_statistics(absolute_errors(found->pairs, *T)).rmse, 0.0504290162447707,
              kSame);
  expect_rpe(found->pairs, 5.0, true, {78, 0.134279754492891, 0.217017650818912},
             {78, 1.99344711337479, 3.91661769849727});
}

}  // namespace
}  // namespace rali::eval
