#include "rali/fleet/frames/start_sift.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/fleet/frames/track_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;
using geometry::Vec3;

FrameStart start_at(const FrameProblem& problem, const YawPose& T, std::vector<int> holds) {
  FrameStart start;
  start.values.T_ref_odom = {YawPose{}, T};
  start.values.others.setZero(problem.size() - problem.frame_size());
  start.holds = std::move(holds);
  return start;
}

/// One comparison of scans that fits at each of these positions, to a millimetre.
FrameProblem places_problem(const std::vector<Vec2>& places, double last_chi2,
                            const InitSettings& settings) {
  std::vector<PoseEvidence> evidence;
  for (const Vec2& p : places) {
    PoseEvidence e;
    e.a = kTag;
    e.b = kAnchor;
    e.place_b_m = Vec3(p.x(), p.y(), 0.0);
    e.information = 1e6 * Mat4::Identity();
    e.group = 0;
    evidence.push_back(e);
  }
  evidence.back().chi2 = last_chi2;
  return make_frame_problem({kAnchor, kTag}, {}, evidence, settings);
}

TEST(StartSift, keeps_few_starts_unchanged) {
  const FrameProblem problem = places_problem({{0, 0}, {5, 0}}, 0.0, plain_settings());
  const YawPose off{0.1, Vec3(1.0, 2.0, 3.0)};
  const std::vector<FrameStart> kept = sift_starts(problem, {start_at(problem, off, {1})}, 1);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].values.T_ref_odom[1].t_m, off.t_m);
  EXPECT_EQ(kept[0].holds, std::vector<int>{1});
}

// Solving each with all errors of the paths took 24 s for one pair of groups in a tunnel.
TEST(StartSift, merges_200_starts_that_converge_to_one_solution) {
  InitSettings settings;
  const std::vector<Vec2> x = along({{0, 0}, {10, 0}, {10, 10}}, 0.5);
  std::vector<Vec2> y = along({{0, 0}, {0, 4}, {4, 4}}, 0.2);
  y.resize(x.size(), y.back());
  const YawPose truth{0.4, Vec3(6.0, -3.0, 0.0)};
  const PairTrack track = track_of(x, y, exact_ranges(x, y, truth), settings);
  const FrameProblem problem = make_frame_problem({kAnchor, kTag}, {track}, {}, settings);
  std::vector<FrameStart> starts;
  for (int k = 0; k < 200; ++k) {
    const YawPose T{0.4 + 1e-3 * k, truth.t_m + Vec3(0.01 * k, 0.0, 0.0)};
    starts.push_back(start_at(problem, T, {}));
  }
  const std::vector<FrameStart> kept = sift_starts(problem, std::move(starts), 1);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_LT((kept[0].values.T_ref_odom[1].t_m - truth.t_m).norm(), 0.05);
  EXPECT_EQ(kept[0].values.others.size(), problem.size() - problem.frame_size());
}

// Twenty comparisons that agree must not displace another place that also fits: a frame with a
// rival would be accepted.
TEST(StartSift, keeps_a_distant_start_among_many_similar_ones) {
  InitSettings settings = plain_settings();
  settings.search.starts_max = 8;
  std::vector<Vec2> places;
  for (int k = 0; k < 20; ++k) places.emplace_back(0.02 * k, 0.0);
  places.emplace_back(50.0, 0.0);
  const FrameProblem problem = places_problem(places, 5.0, settings);
  std::vector<FrameStart> starts;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const YawPose T{0.0, Vec3(places[k].x(), 0.0, 0.0)};
    starts.push_back(start_at(problem, T, {static_cast<int>(k)}));
  }
  const std::vector<FrameStart> kept = sift_starts(problem, std::move(starts), 1);
  EXPECT_EQ(kept.size(), 8U);
  EXPECT_TRUE(std::any_of(kept.begin(), kept.end(), [](const FrameStart& s) {
    return s.values.T_ref_odom[1].t_m.x() > 49.0;
  }));
}

}  // namespace
}  // namespace rali::fleet
