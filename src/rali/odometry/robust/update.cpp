#include "rali/odometry/robust/update.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kRadian = 180.0 / std::numbers::pi;

/// LiDAR system in terms of the error about the prediction instead of the iterate.
void move_to_prior(const Vec3& theta, LidarSystem& system) {
  const Mat3 J = geometry::so3_right_jacobian(theta);
  system.I.topRows<3>() = (J.transpose() * system.I.topRows<3>()).eval();
  system.I.leftCols<3>() = (system.I.leftCols<3>() * J).eval();
  system.b.head<3>() = (J.transpose() * system.b.head<3>()).eval();
}

/// Directions in state space that the scan must not change: position and speed along unobservable
/// translations. Zeros in its information are not enough. With a loose prior, an axis that jitters
/// by a milliradian from scan to scan, or bends, turns lateral information into speed along the
/// tunnel. So these are considered, not estimated (Schmidt 1966).
class Untouched {
 public:
  /// @param R_odom_v rotates the state's velocity to odom: the identity with inertial data.
  Untouched(std::span<const degeneracy::DirectionInfo, 6> directions, const Mat3& R_odom_v) {
    for (const degeneracy::DirectionInfo& info : directions.first<3>()) {
      if (info.information <= 0.0) axes_ += info.direction_odom * info.direction_odom.transpose();
    }
    axes_v_ = R_odom_v.transpose() * axes_ * R_odom_v;
  }

  [[nodiscard]] const Mat3& axes() const { return axes_; }

  /// Removes the untouched part from the rows of M.
  template <class M>
  void clear_rows(M& m) const {
    m.template middleRows<3>(kPos) -= (axes_ * m.template middleRows<3>(kPos)).eval();
    m.template middleRows<3>(kVel) -= (axes_v_ * m.template middleRows<3>(kVel)).eval();
  }

  /// The LiDAR's information on the rest does not depend on the position along unobservable
  /// directions: the error state is relative to the screw that describes this dependence
  /// (bend.hpp).
  void clear_coupling(LidarSystem& system) const {
    Mat6 rest = Mat6::Identity();
    rest.bottomRightCorner<3, 3>() -= axes_;
    system.I = (rest * system.I * rest).eval();
    system.b = (rest * system.b).eval();
  }

  /// How a pose of covariance P follows the map: along untouched directions not at all, and the
  /// others without their correlation with these.
  [[nodiscard]] MapFollowing following(const Mat6& P, const Mat6& information) const {
    Mat6 degenerate = Mat6::Zero();
    degenerate.bottomRightCorner<3, 3>() = axes_;
    const Mat6 rest = Mat6::Identity() - degenerate;
    return MapFollowing::of(rest * P * rest + degenerate * P * degenerate,
                            rest * information * rest);
  }

  /// Augmented states are estimated like the pose if the LiDAR is not degenerate. Along a
  /// degenerate axis they depend on the pose, which depends on lateral observations only by how
  /// straight the path is: lateral millimetres would become metres of a landmark's position.
  [[nodiscard]] bool estimates_augmented() const { return axes_.isZero(0.0); }

 private:
  Mat3 axes_ = Mat3::Zero();    ///< projector on the degenerate translations
  Mat3 axes_v_ = Mat3::Zero();  ///< the same for the velocity
};

/// A degenerate direction stays so whatever the information of this scan.
void keep_degenerate(const std::array<bool, 3>& degenerate_before, UpdateResult& result) {
  for (std::size_t d = 0; d < 3; ++d) {
    degeneracy::DirectionInfo& info = result.directions[d];
    result.sees[d] = info.information > 0.0;
    if (!degenerate_before[d]) continue;
    info.information = 0.0;
    info.sigma = std::numeric_limits<double>::infinity();
    info.category = degeneracy::Category::kNone;
  }
}

/// Weak structure in several clusters supports a direction, unless at standstill: then passers-by
/// give as weak structure in as many clusters, and the pose that they drag along does not recover.
degeneracy::AwareSettings belief(const degeneracy::AwareSettings& aware, const FilterState& state,
                                 bool inertial) {
  constexpr double kStanding_mps = 0.2;
  degeneracy::AwareSettings out = aware;
  out.trusts_support = inertial && state.v.norm() >= kStanding_mps;
  return out;
}

void symmetrise(StateCov& P) { P = 0.5 * (P + P.transpose()).eval(); }

/// Covariance after the update, transported from the prediction's tangent space to the estimate's.
void set_posterior(FilterState& state, const FilterState& predicted, const Mat6& I,
                   const Untouched& untouched, const Vec3& theta) {
  const StateCov& P = predicted.P;
  const Mat6 S = Mat6::Identity() + I * P.topLeftCorner<6, 6>();
  const Mat6 gain = S.partialPivLu().solve(I);
  // With K the optimal gain and T the changeable part: (1 - TKH) P (1 - TKH)' + TK R K'T'.
  const StateCov Q = P.leftCols<6>() * gain * P.topRows<6>();
  StateCov TQ = Q;
  untouched.clear_rows(TQ);
  StateCov TQT = TQ.transpose();
  untouched.clear_rows(TQT);
  StateCov out = P - TQ - TQ.transpose() + TQT;
  const Mat3 J = geometry::so3_right_jacobian(theta);
  out.topRows<3>() = (J * out.topRows<3>()).eval();
  out.leftCols<3>() = (out.leftCols<3>() * J.transpose()).eval();
  symmetrise(out);
  state.P = out;
  if (predicted.augmented.size() == 0) return;
  using PoseCross = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, AugmentedStates::kMax>;
  const PoseCross gained = gain * predicted.P_augmented.topRows<6>();
  AugmentedCross taken = P.leftCols<6>() * gained;
  if (untouched.estimates_augmented()) {
    state.augmented.covariance =
        predicted.augmented.covariance - predicted.P_augmented.topRows<6>().transpose() * gained;
  } else {
    untouched.clear_rows(taken);
  }
  state.P_augmented = predicted.P_augmented - taken;
  state.P_augmented.topRows<3>() = (J * state.P_augmented.topRows<3>()).eval();
}

/// The covariance after the last iteration, and how the pose followed the map.
void finish(const FilterState& predicted, const Mat6& I, const Vec3& theta,
            const Untouched& untouched, FilterState& state, UpdateResult& result) {
  set_posterior(state, predicted, I, untouched, theta);
  result.following = untouched.following(predicted.P.topLeftCorner<6, 6>(), I);
  result.untouched = untouched.axes();
}

/// Compares the LiDAR alone with the prediction. A weak prior replaces all that is unobservable:
/// "as predicted, to a metre", which no prediction contradicts.
void compare_with_prediction(const Vec6& y, const Mat6& P66, const Mat3& R_odom_body,
                             UpdateResult& result) {
  constexpr double kOpen_m = 1.0;
  constexpr double kOpen_rad = 0.3;
  constexpr double kKnown_m = 0.02;
  constexpr double kKnown_rad = 0.003;
  Mat6 I = result.information;
  I.diagonal().head<3>().array() += 1.0 / (kOpen_rad * kOpen_rad);
  I.diagonal().tail<3>().array() += 1.0 / (kOpen_m * kOpen_m);
  const Mat6 R = I.inverse();
  result.lidar_shift = R * y;
  const Mat6 S = 0.5 * (P66 + P66.transpose()) + R;
  result.nis = result.lidar_shift.dot(S.partialPivLu().solve(result.lidar_shift));
  result.known.setZero();
  result.rotation_known.setZero();
  for (const degeneracy::DirectionInfo& info : std::span(result.directions).first<3>()) {
    if (info.sigma > kKnown_m) continue;
    result.known += info.direction_odom * info.direction_odom.transpose();
  }
  for (const degeneracy::DirectionInfo& info : std::span(result.directions).last<3>()) {
    if (info.sigma > kKnown_rad) continue;
    const Vec3 d_body = R_odom_body.transpose() * info.direction_odom;
    result.rotation_known += d_body * d_body.transpose();
  }
}

/// Removes spurious and unobservable information from the system.
void keep_what_is_seen(const FilterState& state, const Mat3& R_odom_v, bool inertial,
                       LidarSystem& system, UpdateResult& result) {
  const Mat3& R = state.T_odom_body.R;
  const Vec6 screw = degeneracy::least_motion(system.I, 0, R, result.axes);
  result.bend_radpm = -state.g_odom_mps2.normalized().dot(R * screw.head<3>());
  degeneracy::remove_spurious(system.I, system.b, R, result.directions);
  if (inertial) Untouched(result.directions, R_odom_v).clear_coupling(system);
}

/// @return true: match again
bool moved_on(const StateVec& delta, const Vec6& before, const UpdateSettings& settings,
              UpdateResult& result) {
  const double step_m = (delta.segment<3>(kPos) - before.tail<3>()).norm();
  const double step_deg = kRadian * (delta.segment<3>(kTheta) - before.head<3>()).norm();
  result.converged = step_m < settings.stop_m && step_deg < settings.stop_deg;
  return step_m > settings.rematch_m || step_deg > 0.2;
}

void report_fit(const LidarSystem& system, const Matcher& matcher, UpdateResult& result) {
  result.fit = system.weight_sum / static_cast<double>(matcher.size());
  if (system.weight_sum > 0.0) {
    result.residual_rms_m = std::sqrt(system.residual_sum2_m2 / system.weight_sum);
  }
}

/// From a poor guess, a first stage searches the pose with all candidate planes. A second one
/// refines it with only those whose points surround the scan's. If these are too few, e.g. in a map
/// of one scan, the pose of the search is kept.
class Stages {
 public:
  Stages(bool poor, int iterations_max)
      : searching_(poor), end_(iterations_max), iterations_max_(iterations_max) {}

  /// Planes used in iteration k.
  [[nodiscard]] Reach reach(int k) const {
    if (!searching_) return few_ ? Reach::kCell : Reach::kPoints;
    return k + 2 < iterations_max_ ? Reach::kNear : Reach::kCell;
  }

  [[nodiscard]] bool goes_on(int k) const { return k < end_; }

  /// After iteration k. @return true: the next stage starts, with other matches
  bool next(int k, bool converged) {
    if (searching_ && (converged || k + 1 == end_)) {
      searching_ = false;
      found_ = true;
      end_ = k + 1 + kMeasuring;
      return true;
    }
    if (converged) end_ = k + 1;
    return false;
  }

  /// Too few matches in iteration k. @return true: continue with more of them
  bool has_few(int k) {
    if (!found_ || few_) return false;
    few_ = true;
    end_ = k + 2;
    return true;
  }

 private:
  static constexpr int kMeasuring = 2;
  bool searching_, found_ = false, few_ = false;
  int end_, iterations_max_;
};

}  // namespace

bool is_rotation_uncertain(const Mat6& P_pose) {
  constexpr double kTurned_rad = 0.02;
  return P_pose.diagonal().head<3>().maxCoeff() > kTurned_rad * kTurned_rad;
}

UpdateResult update_with_scan(FilterState& state, Matcher& matcher, const PlaneMap& map,
                              const geometry::SE3& start, const RobustSettings& settings,
                              const degeneracy::Axes& axes_before,
                              const std::array<bool, 3>& degenerate_before, bool inertial) {
  const FilterState predicted = state;
  const Mat6 P66 = predicted.P.topLeftCorner<6, 6>();
  const Mat3 R_odom_v = inertial ? Mat3::Identity() : predicted.T_odom_body.R;
  const degeneracy::AwareSettings aware = belief(settings.aware, predicted, inertial);
  Stages stages(!inertial || is_rotation_uncertain(P66), settings.update.iterations_max);
  UpdateResult result;
  result.axes = axes_before;
  StateVec delta = StateVec::Zero();
  delta.head<6>() = geometry::boxminus(start, predicted.T_odom_body);
  add_error(state, delta);
  LidarSystem system;
  Vec6 y_lidar = Vec6::Zero();
  bool rematch = true;
  for (int k = 0; stages.goes_on(k); ++k) {
    if (k < 2 || rematch) matcher.match(map, state.T_odom_body, P66, stages.reach(k));
    system = matcher.accumulate(map, state.T_odom_body);
    result.iterations = k + 1;
    result.matches = system.matches;
    if (system.matches < settings.update.matches_min) {
      rematch = stages.has_few(k);
      if (rematch) continue;
      state = predicted;
      return result;
    }
    result.axes = degeneracy::physical_axes(system.I, state.g_odom_mps2, state.T_odom_body.R,
                                            axes_before, aware);
    result.directions = degeneracy::direction_information(system.I, matcher.evidence(),
                                                          state.T_odom_body.R, result.axes, aware);
    keep_degenerate(degenerate_before, result);
    keep_what_is_seen(state, R_odom_v, inertial, system, result);
    result.information = system.I;
    result.mean_epoch = system.mean_epoch;

    const Vec6 before = delta.head<6>();
    move_to_prior(before.head<3>(), system);
    const Mat6 A = Mat6::Identity() + system.I * P66;
    y_lidar = system.I * before - system.b;
    const Vec6 y = A.partialPivLu().solve(y_lidar);
    delta = predicted.P.leftCols<6>() * y;
    const Untouched untouched(result.directions, R_odom_v);
    untouched.clear_rows(delta);
    state = predicted;
    add_error(state, delta);
    if (state.augmented.size() > 0 && untouched.estimates_augmented()) {
      state.augmented.mean += predicted.P_augmented.topRows<6>().transpose() * y;
    }
    rematch = moved_on(delta, before, settings.update, result);
    rematch = stages.next(k, result.converged && k > 0) || rematch;
  }
  finish(predicted, system.I, delta.segment<3>(kTheta), Untouched(result.directions, R_odom_v),
         state, result);
  compare_with_prediction(y_lidar, P66, predicted.T_odom_body.R, result);
  report_fit(system, matcher, result);
  return result;
}

template <int D>
void update_linear(FilterState& state, const Eigen::Matrix<double, D, kStateDim>& H,
                   const Eigen::Matrix<double, D, 1>& residual,
                   const Eigen::Matrix<double, D, D>& R) {
  const Eigen::Matrix<double, kStateDim, D> PHt = state.P * H.transpose();
  const Eigen::Matrix<double, D, D> S = H * PHt + R;
  const Eigen::Matrix<double, kStateDim, D> K = PHt * S.inverse();
  const StateCov A = StateCov::Identity() - K * H;
  state.P = A * state.P * A.transpose() + K * R * K.transpose();  // Joseph form: stays positive
  symmetrise(state.P);
  if (state.augmented.size() > 0) {
    using AugmentedRows = Eigen::Matrix<double, Eigen::Dynamic, D, 0, AugmentedStates::kMax, D>;
    const AugmentedRows augmented_PHt = state.P_augmented.transpose() * H.transpose();
    const AugmentedRows augmented_K = augmented_PHt * S.inverse();
    state.augmented.mean += augmented_K * residual;
    state.augmented.covariance -= augmented_K * augmented_PHt.transpose();
    state.P_augmented -= PHt * augmented_K.transpose();
  }
  add_error(state, K * residual);
}

template void update_linear<1>(FilterState&, const Eigen::Matrix<double, 1, kStateDim>&,
                               const Eigen::Matrix<double, 1, 1>&,
                               const Eigen::Matrix<double, 1, 1>&);
template void update_linear<3>(FilterState&, const Eigen::Matrix<double, 3, kStateDim>&,
                               const Eigen::Matrix<double, 3, 1>&,
                               const Eigen::Matrix<double, 3, 3>&);
template void update_linear<2>(FilterState&, const Eigen::Matrix<double, 2, kStateDim>&,
                               const Eigen::Matrix<double, 2, 1>&,
                               const Eigen::Matrix<double, 2, 2>&);

}  // namespace rali::odometry
