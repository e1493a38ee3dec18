#include "rali/eval/gauge.hpp"

#include <numbers>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/consistency.hpp"

namespace rali::eval {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

constexpr double kDegree = std::numbers::pi / 180.0;

SE3 pose(double x, double y, double z, double yaw_deg = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_deg * kDegree), Vec3(x, y, z)};
}

PosePair pair_of(double t_s, const SE3& est, const SE3& ref) {
  return {Time::from_s(t_s), est, ref, 0};
}

TEST(Gauge, nees_relative_to_the_reference_pose_matches_hand_computed_values) {
  // The reference is at (1, 0, 0) in map, heading along y; in the world it is at the origin.
  const Gauge gauge = gauge_of(pair_of(1.0, pose(1, 0, 0, 90.0), pose(0, 0, 0)));
  // 10 m ahead: at (1, 10, 0) in map. The estimate is 0.3 m too far with a sigma of 0.1 m.
  const SE3 truth = gauge.T_est_ref * pose(10, 0, 0);
  EXPECT_NEAR((truth.p - Vec3(1, 10, 0)).norm(), 0.0, 1e-12);
  const Mat6 P = 0.01 * Mat6::Identity();
  EXPECT_NEAR(*nees_position(pose(1, 10.3, 0, 90.0), truth, P), 9.0, 1e-9);
  EXPECT_NEAR(*nees_pose(pose(1, 10.3, 0, 90.0), truth, P), 9.0, 1e-9);
}

TEST(Gauge, heading_error_of_the_reference_shifts_all_other_poses) {
  // The estimated reference is rotated by 1 degree: a lateral error of 0.1745 m at 10 m ahead.
  const Gauge gauge = gauge_of(pair_of(1.0, pose(0, 0, 0, 1.0), pose(0, 0, 0)));
  const SE3 truth = gauge.T_est_ref * pose(10, 0, 0);
  EXPECT_NEAR((truth.p - Vec3(10, 0, 0)).norm(), 10.0 * kDegree, 1e-4);
}

// The reference stands, takes itself for pitched by 2 degrees and heads along y in map; the other
// vehicle is level. At 10 m ahead the reference's own level would be 0.35 m in height.
TEST(Gauge, may_have_the_heading_of_one_pose_and_the_level_of_another) {
  SE3 tilted = pose(1, 0, 0, 90.0);
  tilted.R = tilted.R * geometry::rotation_from_rpy(0.0, 2.0 * kDegree, 0.0);
  const PosePair reference = pair_of(1.0, tilted, pose(0, 0, 0));
  const PosePair level = pair_of(1.0, pose(3, 0, 0, 91.0), pose(0, -2, 0));
  const SE3 truth = gauge_of(reference, level).T_est_ref * pose(10, 0, 0);
  EXPECT_NEAR((truth.p - Vec3(1, 10, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(std::abs((gauge_of(reference).T_est_ref * pose(10, 0, 0)).p.z()), 0.349, 1e-3);
  const SE3 same =
      gauge_of(reference, reference).T_est_ref.inverse() * gauge_of(reference).T_est_ref;
  EXPECT_TRUE(same.R.isIdentity(1e-12));
  EXPECT_LT(same.p.norm(), 1e-12);
}

TEST(Gauge, holds_only_while_estimate_and_ground_truth_stay_at_the_reference) {
  const Gauge gauge = gauge_of(pair_of(1.0, pose(1, 0, 0, 90.0), pose(0, 0, 0)));
  EXPECT_TRUE(gauge.holds(pair_of(1.0, pose(1, 0, 0, 90.0), pose(0, 0, 0))));
  EXPECT_TRUE(gauge.holds(pair_of(60.0, pose(1.003, 0, 0, 90.1), pose(0.0001, 0, 0))));
  EXPECT_FALSE(gauge.holds(pair_of(60.0, pose(1.01, 0, 0, 90.0), pose(0, 0, 0))))
      << "it stands, but the estimate has drifted";
  EXPECT_FALSE(gauge.holds(pair_of(60.0, pose(1, 0, 0, 90.0), pose(0.01, 0, 0))))
      << "it was moved, and the estimate does not know";
  EXPECT_FALSE(gauge.holds(pair_of(60.0, pose(1, 0, 0, 90.5), pose(0, 0, 0))));
  EXPECT_FALSE(Gauge{}.holds(pair_of(0.0, SE3{}, SE3{}))) << "the truth's own frame";
}

Vec6 drawn(const Mat6& P, Rng& rng) {
  Vec6 n;
  for (double& x : n) x = rng.normal();
  return P.llt().matrixL() * n;
}

/// A vehicle whose errors are drawn from its covariances: a start, and steps of 1 m on a curve.
struct Drawn {
  PairList pairs;
  std::vector<Mat6> covariances;  ///< relative to the reference

  Drawn(const SE3& T_world_map, const SE3& start, const Mat6& P_start, Rng& rng) {
    const Mat6 Q = (Vec6() << 1e-4, 1e-4, 2e-4, 4e-4, 1e-4, 1e-4).finished().asDiagonal();
    const SE3 step{geometry::rotation_from_rpy(0.01, -0.02, 0.1), Vec3(1.0, 0.0, 0.05)};
    SE3 truth = start, est = geometry::boxplus(start, drawn(P_start, rng));
    Mat6 P = P_start;
    for (int k = 0; k < 25; ++k) {
      pairs.push_back({Time::from_s(k), est, T_world_map * truth, static_cast<std::size_t>(k)});
      covariances.push_back(P);
      Mat6 F = Mat6::Identity(), G = Mat6::Identity();
      F.topLeftCorner<3, 3>() = step.R.transpose();
      F.bottomLeftCorner<3, 3>() = -est.R * geometry::skew(step.p);
      G.bottomRightCorner<3, 3>() = est.R;
      P = F * P * F.transpose() + G * Q * G.transpose();
      est = est * geometry::boxplus(step, drawn(Q, rng));
      truth = truth * step;
    }
  }
};

/// Mean over runs of the NEES at the end of the path, with scaled covariances.
struct MeanNees {
  double pose = 0.0, position = 0.0, fitted = 0.0;
};

constexpr int kRuns = 400;

/// Two vehicles: the first starts at the reference, the second with a start sigma of 0.1 m and 1
/// degree. Runs alternate between them.
MeanNees mean_nees(double scale) {
  Rng rng(7);
  MeanNees mean;
  const Mat6 P_other =
      (Vec6() << Vec3::Constant(kDegree * kDegree), Vec3::Constant(0.01)).finished().asDiagonal();
  for (int run = 0; run < kRuns; ++run) {
    const SE3 T_world_map{geometry::rotation_from_rpy(0.0, 0.0, rng.uniform(-3.0, 3.0)),
                          Vec3(rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0), 2.0)};
    const SE3 T_map_ref{geometry::rotation_from_rpy(0.02, -0.01, 0.0), Vec3::Zero()};
    const Gauge gauge = gauge_of(pair_of(0.0, T_map_ref, T_world_map * T_map_ref));
    const bool other = run % 2 == 1;
    const Drawn v = other ? Drawn(T_world_map, pose(3, 1, 0, 40.0), P_other, rng)
                          : Drawn(T_world_map, T_map_ref, 1e-18 * Mat6::Identity(), rng);
    const PosePair& end = v.pairs.back();
    const Mat6 P = scale * v.covariances.back();
    const SE3 truth = gauge.T_est_ref * end.ref;
    mean.pose += nees_pose(end.est, truth, P).value() / kRuns;
    mean.position += nees_position(end.est, truth, P).value() / kRuns;
    const SE3 T_truth_est = align(v.pairs, Alignment::kSe3).value();
    mean.fitted += nees_position(end.est, T_truth_est.inverse() * end.ref, P).value() / kRuns;
  }
  return mean;
}

bool within(double mean, int dof) {
  const NeesBounds bounds = nees_bounds(kRuns, dof);
  return mean > bounds.low && mean < bounds.high;
}

TEST(Gauge, nees_of_consistent_trajectories_equals_their_dimension) {
  const MeanNees honest = mean_nees(1.0);
  EXPECT_TRUE(within(honest.pose, 6)) << honest.pose;
  EXPECT_TRUE(within(honest.position, 3)) << honest.position;
  EXPECT_LT(honest.fitted, 0.5 * honest.position) << "a fit of all poses hides most of the error";
}

TEST(Gauge, nees_detects_covariances_wrong_by_a_factor_of_two) {
  for (const double scale : {0.5, 2.0}) {
    const MeanNees wrong = mean_nees(scale);
    EXPECT_FALSE(within(wrong.pose, 6)) << wrong.pose;
    EXPECT_FALSE(within(wrong.position, 3)) << wrong.position;
  }
}

}  // namespace
}  // namespace rali::eval
