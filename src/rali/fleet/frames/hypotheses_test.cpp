#include "rali/fleet/frames/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/fleet/frames/commit_gate.hpp"
#include "rali/fleet/frames/track_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;
using geometry::Vec3;

const std::vector<Vec2> kL = {{0, 0}, {2, 0}, {4, 0}, {4, 2}, {4, 4}};
const YawPose kTruth{30.0 * kDegree, Vec3(4.0, 1.0, 0.0)};

Eigen::Matrix3d planar(const Mat4& I) { return I.topLeftCorner<3, 3>(); }

const FrameHypothesis* nearest(const HypothesisSet& set, const YawPose& T) {
  const FrameHypothesis* best = nullptr;
  double minimum = std::numeric_limits<double>::infinity();
  for (const FrameHypothesis& h : set.all) {
    const double d =
        (h.T_b_a.t_m - T.t_m).norm() + 5.0 * std::abs(wrapped(h.T_b_a.yaw_rad - T.yaw_rad));
    if (d < minimum) best = &h;
    minimum = std::min(minimum, d);
  }
  return best;
}

// T13: if the heading seemed observable here, a fleet would commit to a rotated map.
TEST(Hypotheses, from_ranges_to_a_standing_vehicle_leave_the_heading_unobservable) {
  const InitSettings settings = plain_settings();
  const PairTrack track = track_of(kL, {{0, 0}}, exact_ranges(kL, {{0, 0}}, kTruth), settings);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      planar(pair_information(track, kTruth, settings)));
  EXPECT_NEAR(solver.eigenvalues()[0] / solver.eigenvalues()[2], 0.0, 1e-9);
  EXPECT_NEAR(solver.eigenvalues()[1], 368.6, 0.05);
  EXPECT_NEAR(solver.eigenvalues()[2], 2423.8, 0.05);
  const Eigen::Vector3d null = solver.eigenvectors().col(0) / solver.eigenvectors()(0, 0);
  EXPECT_NEAR(null[1], -1.0, 1e-6);
  EXPECT_NEAR(null[2], 4.0, 1e-6);

  const HypothesisSet set = range_hypotheses(track, settings);
  ASSERT_FALSE(set.all.empty());
  EXPECT_TRUE(set.b_stands);
  // The anchor's position in the tag's frame is observable: p = R'(y - t).
  const Vec3 p = kTruth.inverse() * Vec3(Vec3::Zero());
  EXPECT_NEAR((set.all.front().T_b_a.inverse() * Vec3(Vec3::Zero()) - p).norm(), 0.0, 1e-3);
  const Observability seen = observability(set, settings);
  EXPECT_EQ(seen.advice, Advice::kHeadingUnknown);
  EXPECT_FALSE(decide(set, seen, 0, settings).ready);
  EXPECT_EQ(advice_text(seen.advice, seen, "v2", "v1", settings),
            "v2: heading against v1 unknown; ranges to a standing vehicle cannot give it. Let v1 "
            "see v2's mapped area, or move v1 2 m off its place");
}

// T14: if one of the two were lost, half of all starts would commit to the mirror image.
TEST(Hypotheses, from_a_straight_path_are_two_mirror_images) {
  const InitSettings settings = plain_settings();
  const std::vector<Vec2> line = {{0, 0}, {2, 0}, {4, 0}, {6, 0}};
  const std::vector<double> ranges = {5.0, 4.1231, 4.1231, 5.0};
  std::vector<PlanarRange> planar;
  for (std::size_t i = 0; i < 4; ++i) planar.push_back({line[i], {0, 0}, ranges[i], 0.07});
  const LinearStart start = linear_start(planar, 0.0);
  EXPECT_NEAR(-start.t_m.x(), 3.0, 1e-3);
  EXPECT_NEAR(start.square_m2, 25.0, 1e-3);

  const HypothesisSet set = range_hypotheses(track_of(line, {{0, 0}}, ranges, settings), settings);
  ASSERT_EQ(set.all.size(), 2u);
  std::vector<Vec3> places;
  for (const FrameHypothesis& h : set.all) {
    places.push_back(h.T_b_a.inverse() * Vec3(Vec3::Zero()));
  }
  if (places[0].y() < 0.0) std::swap(places[0], places[1]);
  EXPECT_NEAR((places[0] - Vec3(3, 4, 0)).norm(), 0.0, 1e-3);
  EXPECT_NEAR((places[1] - Vec3(3, -4, 0)).norm(), 0.0, 1e-3);
  EXPECT_FALSE(decide(set, observability(set, settings), 0, settings).ready);
}

// T15
TEST(Hypotheses, from_two_differently_turning_paths_are_unambiguous) {
  const InitSettings settings = plain_settings();
  const std::vector<Vec2> other = {{0, 0}, {2, 0}, {2, -2}, {2, -4}, {0, -4}};
  const PairTrack track = track_of(kL, other, {4.1231, 4.2342, 7.4065, 9.8070, 11.8048}, settings);
  const Eigen::Matrix3d I = planar(pair_information(track, kTruth, settings));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(I);
  EXPECT_NEAR(solver.eigenvalues()[0], 101.9, 0.05);
  EXPECT_NEAR(solver.eigenvalues()[1], 516.5, 0.05);
  EXPECT_NEAR(solver.eigenvalues()[2], 914.3, 0.05);
  const Eigen::Matrix3d C = I.inverse();
  EXPECT_NEAR(std::sqrt(C(0, 0)) / kDegree, 2.59, 0.005);
  EXPECT_NEAR(std::sqrt(C(1, 1)), 0.071, 0.0005);
  EXPECT_NEAR(std::sqrt(C(2, 2)), 0.076, 0.0005);

  InitSettings quadratic = settings;
  quadratic.search.huber = 100.0;
  const HypothesisSet set = range_hypotheses(track, quadratic);
  ASSERT_GE(set.all.size(), 2u);
  EXPECT_NEAR(set.all[0].T_b_a.yaw_rad, 30.0 * kDegree, 1e-4);
  EXPECT_NEAR((set.all[0].T_b_a.t_m - kTruth.t_m).norm(), 0.0, 1e-3);
  EXPECT_NEAR(set.all[1].chi2, 287.0, 1.0);
}

// T15b: counting ranges would commit here; five are not enough, nor are five hundred.
TEST(Hypotheses, from_two_similar_paths_are_ambiguous) {
  const InitSettings settings = plain_settings();
  const std::vector<Vec2> other = {{0, 0}, {0, 1}, {0, 2}, {-1, 2}, {-2, 2}};
  const PairTrack track = track_of(kL, other, {4.1231, 5.8186, 7.5308, 7.9484, 8.6972}, settings);
  const HypothesisSet set = range_hypotheses(track, settings);
  ASSERT_GE(set.all.size(), 2u);
  const FrameHypothesis* one = nearest(set, kTruth);
  const FrameHypothesis* two = nearest(set, {150.0 * kDegree, Vec3(-4.0, -1.0, 0.0)});
  EXPECT_NEAR(one->T_b_a.yaw_rad, 30.0 * kDegree, 1e-3);
  EXPECT_NEAR((one->T_b_a.t_m - Vec3(4, 1, 0)).norm(), 0.0, 1e-2);
  EXPECT_NEAR(two->T_b_a.yaw_rad, 150.0 * kDegree, 1e-3);
  EXPECT_NEAR((two->T_b_a.t_m - Vec3(-4, -1, 0)).norm(), 0.0, 1e-2);
  EXPECT_LT(one->chi2, 1e-3);
  EXPECT_LT(two->chi2, 1e-3);
  const Observability seen = observability(set, settings);
  EXPECT_EQ(seen.advice, Advice::kAlike);
  EXPECT_FALSE(decide(set, seen, 0, settings).ready);
}

TEST(Hypotheses, transform_with_the_odom_frames_and_keep_their_chi2) {
  const InitSettings settings;
  const std::vector<Vec2> x = along({{0, 0}, {10, 0}, {10, 10}}, 0.5);
  std::vector<Vec2> y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double s = 8.0 * static_cast<double>(i) / static_cast<double>(x.size() - 1);
    y.emplace_back(std::min(s, 4.0), -std::max(0.0, s - 4.0));
  }
  std::vector<double> ranges = exact_ranges(x, y, kTruth);
  Rng rng(1, "frames");
  for (double& r : ranges) r += 0.07 * rng.normal();
  const YawPose A{1.1, Vec3(300.0, -50.0, 0.0)};
  const YawPose B{-2.0, Vec3(-70.0, 20.0, 0.0)};
  std::vector<Vec2> x_moved, y_moved;
  for (const Vec2& p : x) x_moved.push_back((A * Vec3(p.x(), p.y(), 0.0)).head<2>());
  for (const Vec2& p : y) y_moved.push_back((B * Vec3(p.x(), p.y(), 0.0)).head<2>());
  const HypothesisSet set = range_hypotheses(track_of(x, y, ranges, settings), settings);
  const HypothesisSet moved =
      range_hypotheses(track_of(x_moved, y_moved, ranges, settings), settings);
  ASSERT_FALSE(set.all.empty());
  ASSERT_FALSE(moved.all.empty());
  const YawPose expected = B * set.all.front().T_b_a * A.inverse();
  EXPECT_NEAR(wrapped(moved.all.front().T_b_a.yaw_rad - expected.yaw_rad), 0.0, 1e-4);
  EXPECT_NEAR((moved.all.front().place_b_m() - expected * moved.all.front().pivot_a_m).norm(), 0.0,
              2e-3);
  EXPECT_NEAR(moved.all.front().chi2, set.all.front().chi2, 1e-3);
  EXPECT_NEAR((moved.all.front().place_b_m() - B * (kTruth * Vec3(Vec3::Zero()))).norm(), 0.0, 0.5);
}

// A scan constrains heading modulo 180 deg and the lateral position; ranges constrain the position
// along and resolve the ambiguity.
TEST(Hypotheses, from_ranges_and_corridor_scans_together_are_observable) {
  const InitSettings settings;
  const std::vector<Vec2> x = along({{0, 0}, {8, 0.8}, {16, -0.8}, {24, 0}}, 0.5);
  const PairTrack track = track_of(x, {{0, 0}}, exact_ranges(x, {{0, 0}}, kTruth), settings);
  std::vector<PoseEvidence> twins;
  for (const double turn : {0.0, 180.0}) {
    PoseEvidence e;
    e.a = kTag;
    e.b = kAnchor;
    e.group = 7;
    e.yaw_rad = wrapped(kTruth.yaw_rad + turn * kDegree);
    e.place_b_m = kTruth.t_m;
    const Vec3 across(-std::sin(kTruth.yaw_rad), std::cos(kTruth.yaw_rad), 0.0);
    e.information(0, 0) = 1.0 / (0.5 * kDegree * 0.5 * kDegree);
    e.information.bottomRightCorner<3, 3>() = across * across.transpose() / (0.05 * 0.05);
    e.information(3, 3) = 100.0;
    twins.push_back(e);
  }
  EXPECT_FALSE(observability(range_hypotheses(track, settings), settings).sufficient);
  const HypothesisSet set = joint_hypotheses(track, twins, settings);
  ASSERT_FALSE(set.all.empty());
  EXPECT_NEAR(wrapped(set.all.front().T_b_a.yaw_rad - kTruth.yaw_rad), 0.0, 0.5 * kDegree);
  EXPECT_NEAR((set.all.front().T_b_a.t_m - kTruth.t_m).norm(), 0.0, 0.15);
  const Observability seen = observability(set, settings);
  EXPECT_TRUE(seen.sufficient) << seen.eigenvalues.transpose();
}

/// A registration with 1 cm and 0.05 deg at a point of a's frame, where T_b_a is `T`.
PoseEvidence registered(const YawPose& T, const Vec3& pivot_a_m, int group) {
  PoseEvidence e;
  e.a = kTag;
  e.b = kAnchor;
  e.group = group;
  e.unrivalled = true;
  e.yaw_rad = T.yaw_rad;
  e.pivot_a_m = pivot_a_m;
  e.place_b_m = T * pivot_a_m;
  e.information = Vec4(1.0 / std::pow(0.05 * kDegree, 2), 1e4, 1e4, 1e4).asDiagonal();
  return e;
}

// When all were accepted at first, the wrong ones moved the frames by metres, and then all were
// rejected: two halves of one recording were never joined.
TEST(Hypotheses, three_consistent_registrations_outvote_four_contradictory_ones) {
  const InitSettings settings;
  std::vector<PoseEvidence> evidence;
  for (const double x_m : {0.0, 10.0, 20.0}) {
    evidence.push_back(registered(kTruth, Vec3(x_m, 0.0, 0.0), static_cast<int>(x_m)));
  }
  for (int k = 1; k <= 4; ++k) {
    const YawPose wrong{(30.0 + 80.0 * k) * kDegree, Vec3(4.0 + 7.0 * k, 1.0 - 9.0 * k, 0.0)};
    evidence.push_back(registered(wrong, Vec3(5.0 * k, 3.0, 0.0), 100 + k));
  }
  const PairTrack none(kTag, kAnchor, settings.track);
  const HypothesisSet set = joint_hypotheses(none, evidence, settings);
  ASSERT_EQ(set.all.size(), 5U);
  EXPECT_TRUE(set.only_scans);
  EXPECT_NEAR((set.all.front().T_b_a.t_m - kTruth.t_m).norm(), 0.0, 1e-3);
  EXPECT_NEAR(wrapped(set.all.front().T_b_a.yaw_rad - kTruth.yaw_rad), 0.0, 1e-4);
  EXPECT_NEAR(set.all.front().chi2, 4 * 16.0, 0.1);  // four are rejected
  EXPECT_NEAR(set.all[1].chi2, 6 * 16.0, 0.1);
  EXPECT_EQ(set.all.front().views, 3);
  EXPECT_EQ(set.all[1].views, 1);
  EXPECT_TRUE(decide(set, observability(set, settings), 0, settings).ready);
}

// Four matches of the same walls count as one.
TEST(Hypotheses, overlapping_submaps_count_as_one_view) {
  const InitSettings settings;
  std::vector<PoseEvidence> evidence;
  for (int k = 0; k < 4; ++k) {
    evidence.push_back(registered(kTruth, Vec3(2.0 * k, 0.0, 0.0), k));
  }
  const PairTrack none(kTag, kAnchor, settings.track);
  const HypothesisSet set = joint_hypotheses(none, evidence, settings);
  ASSERT_EQ(set.all.size(), 1U);
  EXPECT_EQ(set.all.front().views, 1);
  const Decision d = decide(set, observability(set, settings), 0, settings);
  EXPECT_FALSE(d.ready);
  EXPECT_EQ(d.advice, Advice::kFewViews);
}

/// Alternatives that a comparison with rivals reports, the true one not among them.
std::vector<PoseEvidence> rivals(int groups) {
  const YawPose flipped{wrapped(kTruth.yaw_rad + 180.0 * kDegree), kTruth.t_m};
  std::vector<PoseEvidence> evidence;
  for (int g = 0; g < groups; ++g) {
    evidence.push_back(registered(flipped, Vec3(4.0 * g, 0.0, 0.0), g));
    evidence.back().unrivalled = false;
  }
  return evidence;
}

// In a tunnel the flipped placement alone was found by two of eight comparisons with a vehicle that
// stood still: vehicles were joined the wrong way round and said to be right to 2 m.
TEST(Hypotheses, comparisons_with_rivals_do_not_decide_however_many_they_are) {
  const InitSettings settings;
  const PairTrack none(kTag, kAnchor, settings.track);
  const std::vector<PoseEvidence> few = rivals(1), many = rivals(8);
  for (const std::vector<PoseEvidence>& evidence : {few, many}) {
    std::vector<PoseEvidence> all = evidence;
    all.push_back(registered(kTruth, Vec3(2.0, 5.0, 0.0), 100));
    const HypothesisSet set = joint_hypotheses(none, all, settings);
    ASSERT_GE(set.all.size(), 2U);
    EXPECT_NEAR(wrapped(set.all.front().T_b_a.yaw_rad - kTruth.yaw_rad), 0.0, 1e-3)
        << "one without rivals outvotes them";
    EXPECT_NEAR(set.all.front().chi2, 8.0, 0.1) << "all of them are rejected, for half of one";
    EXPECT_LT(set.all.front().chi2, settings.commit.gap_chi2);
  }
}

/// Past a vehicle that stands 2.8 m beside the middle of 200 m, and one match of scans there.
/// @param stated_m distance to the side by the match
FrameHypothesis passed(double stated_m) {
  const InitSettings settings;
  const std::vector<Vec2> x = along({{0, 0}, {200, 0}}, 0.5);
  const YawPose truth{0.0, Vec3(-100.0, -2.8, 0.0)};
  const PairTrack track = track_of(x, {{0, 0}}, exact_ranges(x, {{0, 0}}, truth), settings);
  const YawPose stated{0.0, Vec3(-100.0, -stated_m, 0.0)};
  PoseEvidence e = registered(stated, Vec3(100.0, 0.0, 0.0), 0);
  e.on_a = ComparedBody{};
  e.on_a->body.t = Time::from_s(200.0);
  e.on_a->body.p_m = e.pivot_a_m;
  e.on_b = ComparedBody{};
  return joint_hypotheses(track, {e}, settings).all.front();
}

// If the match had errors of the path of its own, a tilt of 1.4 deg would put the passed vehicle
// 2.4 m lower and both would agree: vehicles were joined the wrong way round in a tunnel.
TEST(Hypotheses, a_scan_match_shares_the_errors_of_the_path_with_the_ranges) {
  EXPECT_TRUE(passed(2.8).scans);
  EXPECT_LT(passed(2.8).chi2, 1.0);
  EXPECT_FALSE(passed(0.4).scans) << "the ranges say 2.8 m";
}

TEST(Hypotheses, from_invalid_or_too_few_ranges_are_empty_or_undecided) {
  const InitSettings settings;
  EXPECT_TRUE(range_hypotheses(PairTrack(kTag, kAnchor, settings.track), settings).all.empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  PairTrack track(kTag, kAnchor, settings.track);
  RangeObservation o;
  for (const double range : {nan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    o.range_m = range;
    EXPECT_EQ(track.add(o), TrackUse::kRefused);
  }
  o.range_m = 5.0;
  o.x_a_m.x() = nan;
  EXPECT_EQ(track.add(o), TrackUse::kRefused);
  // Two ranges, at the same time and place.
  o.x_a_m.x() = 0.0;
  track.add(o);
  o.x_a_m.x() = 1.0;
  track.add(o);
  const HypothesisSet set = range_hypotheses(track, settings);
  const Observability seen = observability(set, settings);
  EXPECT_EQ(seen.advice, Advice::kWaiting);
  EXPECT_FALSE(decide(set, seen, 0, settings).ready);
  PoseEvidence bad = prior_evidence(kTag, kAnchor, kTruth, settings);
  bad.information(0, 0) = nan;
  EXPECT_EQ(joint_hypotheses(track, {bad}, settings).all.size(), set.all.size());
}

// A column in a tunnel: by its odometry the rear vehicle overtakes the other, which ranges of 5 m
// all along contradict. Fitted to all of them at once, with the errors of the paths as unknowns, it
// jumps to the other side, and a right start pose counted as contradicted.
TEST(Hypotheses, of_a_column_keep_the_start_pose_of_a_path_that_drifts_past_the_other) {
  InitSettings settings;
  settings.prior.xyz_m = 0.1;
  settings.prior.yaw_deg = 1.5;
  const YawPose truth{0.0, Vec3(-4.8, -1.2, 0.0)};
  PairTrack track(kTag, kAnchor, settings.track);
  for (int k = 0; k <= 100; ++k) {
    const double part = 0.01 * k;
    RangeObservation o;
    o.t = Time::from_s(k);
    o.x_a_m.x() = 0.8 * k + 30.0 * part * part;
    o.y_b_m.x() = 0.8 * k;
    o.x_covariance_m2(0, 0) = 225.0 * part * part;
    o.range_m = truth.t_m.norm() + 0.05 * std::sin(k);
    track.add(o);
  }
  const PoseEvidence prior = prior_evidence(kTag, kAnchor, truth, settings);
  const HypothesisSet set = joint_hypotheses(track, {prior}, settings);
  const Decision decision = decide(set, observability(set, settings), 10, settings);
  EXPECT_TRUE(decision.ready);
  EXPECT_EQ(decision.by, DecidedBy::kPrior);
  ASSERT_EQ(decision.chosen, 0U) << "the others reject the start pose";
  EXPECT_LT(set.all[0].prior_chi2, 4.0);
  EXPECT_NEAR(set.all[0].T_b_a.t_m.x(), -4.8, 0.1);
}

/// Two vehicles without ranges; scans give their relative pose, with the given alternatives.
/// @param unrivalled each is a separate place, recognised without rival
std::string by_scans(const std::vector<Vec3>& places_m, double along_sigma_m,
                     bool unrivalled = false) {
  const InitSettings settings = plain_settings();
  std::vector<PoseEvidence> evidence;
  for (const Vec3& at : places_m) {
    PoseEvidence e;
    e.a = {VehicleId{1}, 0};
    e.b = {VehicleId{0}, 0};
    e.place_b_m = at;
    e.information = Vec4(1e6, std::pow(along_sigma_m, -2), 1e4, 1e4).asDiagonal();
    e.group = unrivalled ? static_cast<int>(evidence.size()) : 0;
    e.unrivalled = unrivalled;
    evidence.push_back(e);
  }
  const FrameGroup a{{evidence[0].a}, {YawPose{}}}, b{{evidence[0].b}, {YawPose{}}};
  const HypothesisSet set = group_hypotheses(a, b, {}, evidence, settings);
  const Observability seen = observability(set, settings);
  return advice_text(seen.advice, seen, "v2", "v1", settings);
}

// "Drive on, and turn" is no help for two recordings without ranges.
TEST(Hypotheses, of_similar_places_advise_to_map_a_unique_place) {
  EXPECT_EQ(
      by_scans({Vec3(5, 0, 0), Vec3(10, 0, 0), Vec3(15, 0, 0)}, 0.01),
      "v2: 3 places against v1 look alike; scans alone cannot decide. Let both see a place that "
      "is like no other, or give a start pose (priors)");
}

// KITTI's halves start in motion: the message must not ask the user to look for other places.
TEST(Hypotheses, from_contradictory_unique_matches_report_the_contradiction) {
  EXPECT_EQ(
      by_scans({Vec3(5, 0, 0), Vec3(5.8, 0, 0)}, 0.01, true),
      "v2: places recognised in the map of v1 contradict each other by 0.8 m and 0.0 deg: "
      "the odometry error exceeds its sigma, or one of them is another place. Give a start pose "
      "(priors), or leave out where the sensor started in motion (start_s)");
}

TEST(Hypotheses, from_a_featureless_passage_report_that_scans_fit_everywhere) {
  EXPECT_EQ(
      by_scans({Vec3(5, 0, 0)}, 1e3),
      "v2: its scans fit everywhere along the path of v1; scans alone cannot decide. Let both "
      "see a place that is like no other, or give a start pose (priors)");
}

}  // namespace
}  // namespace rali::fleet
