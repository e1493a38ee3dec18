#include <algorithm>
#include <span>

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Vec3;
using sensor::LidarScan;

/// What going through the start once more changes.
struct RobustOdometry::StartMemory {
  FilterState state, last_posterior;
  PlaneMap map;
  Drift drift;
  VehicleConstraints constraints;
  std::optional<Refusal> refusal;
  degeneracy::Axes axes;
  Mat3 lidar_known;
  std::array<bool, 3> blind;
  Bend bend;
  std::array<int, 3> seeing_scans;
  Time t_blind, t_speed_bounded;
  std::optional<Time> t_seen;
  double fastest_seen_mps, usual_fit, noise_boost;
  int scans_in_map;
  ScanSampler sampler;
};

RobustOdometry::StartMemory RobustOdometry::start_memory() const {
  return {state_,
          last_posterior_,
          map_,
          drift_,
          constraints_,
          refusal_,
          axes_,
          lidar_known_,
          blind_,
          bend_,
          seeing_scans_,
          t_blind_,
          t_speed_bounded_,
          t_seen_,
          fastest_seen_mps_,
          usual_fit_,
          noise_boost_,
          scans_in_map_,
          sampler_};
}

void RobustOdometry::take(const StartMemory& memory) {
  state_ = memory.state;
  last_posterior_ = memory.last_posterior;
  map_ = memory.map;
  drift_ = memory.drift;
  constraints_ = memory.constraints;
  refusal_ = memory.refusal;
  axes_ = memory.axes;
  lidar_known_ = memory.lidar_known;
  blind_ = memory.blind;
  bend_ = memory.bend;
  seeing_scans_ = memory.seeing_scans;
  t_blind_ = memory.t_blind;
  t_speed_bounded_ = memory.t_speed_bounded;
  t_seen_ = memory.t_seen;
  fastest_seen_mps_ = memory.fastest_seen_mps;
  usual_fit_ = memory.usual_fit;
  noise_boost_ = memory.noise_boost;
  scans_in_map_ = memory.scans_in_map;
  sampler_ = memory.sampler;
}

/// Down as the mean force has it, to what vehicles accelerate by over a start.
void RobustOdometry::level_start(const Vec3& g_odom_mps2, FilterState& begin) const {
  const double bias = settings_.initialisation.accel_bias_sigma_mps2;
  const double tilt = kMeanForceSigma_mps2 / settings_.initialisation.gravity_mps2;
  begin.g_odom_mps2 = g_odom_mps2;
  begin.accel_bias_mps2.setZero();
  decorrelate(begin, kAccelBias, 5);
  begin.P.diagonal().segment<3>(kAccelBias).setConstant(bias * bias);
  begin.P.diagonal().segment<2>(kGravity).setConstant(tilt * tilt);
}

/// Goes through the first scans from the first pose on, at a first speed.
RobustOdometry::ReplayFit RobustOdometry::replay(std::span<const LidarScan> scans,
                                                 const FirstSpeed& first, FindingList& findings) {
  FilterState begin = state_;
  begin.t = scans.front().t_end;
  begin.T_odom_body = track_.front().T_odom_body;
  begin.v = first.v_odom_mps;
  decorrelate(begin, kTheta, kGyroBias);
  begin.P.topLeftCorner<6, 6>() = 1e-10 * geometry::Mat6::Identity();
  begin.P.diagonal().segment<3>(kVel).setConstant(first.sigma_mps * first.sigma_mps);
  if (first.g_odom_mps2) {
    level_start(*first.g_odom_mps2, begin);
  } else {
    begin.P.block<5, 5>(kAccelBias, kAccelBias) *= first.variance_factor;
  }
  state_ = begin;
  map_ = PlaneMap(settings_.map);
  scans_in_map_ = 0;
  drift_.establish_all();
  insert_at_constant_speed(scans.front(), gyro_rate(scans.front().t_begin, scans.front().t_end));
  ReplayFit out;
  const double n = static_cast<double>(scans.size() - 1);
  for (const LidarScan& scan : scans.subspan(1)) {
    poses_.clear();
    sampler_.sample(scan);
    predict(scan.t_end);
    const UpdateResult done = update(scan, 1);
    remember_seen(done);
    out.nis += done.nis / n;
    out.on_planes += done.fit / n;
    constrain(done, findings);
    if (done.matches >= settings_.update.matches_min || scans_in_map_ < kYoungScans) insert(scan);
    last_posterior_ = state_;
  }
  return out;
}

namespace {

constexpr double kHonestNis = 6.0;  // of six degrees of freedom

}  // namespace

/// The LiDAR alone may have found another first speed than the true one: the rings that it draws on
/// the floor drive along, and in a young map nothing else weighs more. Gone through at the true
/// one, more of the points of the scans that follow lie on planes. Searched along the body: so
/// ground vehicles drive. Gravity was solved for along another track: its variance is widened, and
/// where many more points lie on planes without it, it is the mean force's, and how well the
/// prediction fits, which begins with a step, counts for nothing.
/// @return nothing: as the guess has it
std::optional<RobustOdometry::FirstSpeed> RobustOdometry::better_first_speed(
    std::span<const LidarScan> scans, const FirstSpeed& guess, const StartMemory& before) {
  constexpr std::size_t kEnough = 40;
  constexpr double kBetter = 1.05;     // as look_around() has it
  constexpr double kMuchBetter = 1.3;  // in open yards wrong ones reach 1.1 by chance
  constexpr double kStep_mps = 0.4;
  constexpr double kSigma_mps = 0.2;
  constexpr int kSteps = 8;
  constexpr double kVarianceFactor =
      10.0;  // 5 to 10 find the same; at 1 and at 20 some starts are lost
  const auto few = scans.first(std::min(kEnough, scans.size()));
  const Vec3 force =
      imu::statistics(imu_.between(scans.front().t_end, scans.back().t_end)).accel_mean_mps2;
  const Mat3& R = track_.front().T_odom_body.R;
  const Vec3 g = -settings_.initialisation.gravity_mps2 * (R * force).normalized();
  FindingList unsaid;
  const double usual = replay(few, guess, unsaid).on_planes;
  double most = kBetter * usual;
  std::optional<FirstSpeed> best;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const Vec3 v = k * kStep_mps * R.col(0);
    for (const bool by_track : {true, false}) {
      take(before);
      const FirstSpeed other{v, kSigma_mps, by_track ? std::nullopt : std::optional(g),
                             kVarianceFactor};
      const ReplayFit fit = replay(few, other, unsaid);
      const bool much = fit.on_planes > kMuchBetter * usual;
      if (!(fit.on_planes > most && (by_track ? fit.nis < kHonestNis : much))) continue;
      most = fit.on_planes;
      best = other;
    }
  }
  take(before);
  return best;
}

/// A vehicle that drove when the recording began: its first scans were undistorted and registered
/// without knowing how it moved. Now that speed, gravity and biases are known, they are gone
/// through once more, and the map is free of what the first second got wrong. The first pose stays.
/// Should scans and prediction disagree on that way, something was felt that was no motion: all
/// stays as it was. Where the LiDAR is degenerate, a map of few scans drags the pose along: once is
/// enough, unless another speed fits better.
void RobustOdometry::replay_start(const InitialGuess& guess, FindingList& findings) {
  if (start_scans_.size() < 2) return;
  const std::vector<LidarScan> scans = std::move(start_scans_);
  start_scans_.clear();
  const StartMemory before = start_memory();
  FirstSpeed first{guess.v_first_mps, guess.v_first_sigma_mps};
  const std::optional<FirstSpeed> other = better_first_speed(scans, first, before);
  if (!other && blind_axis()) return;
  const ReplayFit fit = replay(scans, other.value_or(first), findings);
  if (!other && !(fit.nis < kHonestNis)) take(before);
}

/// The first scan has no motion before it: its own is taken for constant.
void RobustOdometry::insert_at_constant_speed(const LidarScan& scan,
                                              const std::optional<Vec3>& gyro_radps) {
  constexpr int kSteps = 10;
  const double span_s = (scan.t_end - scan.t_begin).s();
  const Vec3 w = gyro_radps ? Vec3(*gyro_radps - state_.gyro_bias_radps) : Vec3::Zero();
  poses_.clear();
  for (int k = 0; k <= kSteps; ++k) {
    const double ago_s = span_s * (kSteps - k) / kSteps;
    const Mat3 R = state_.T_odom_body.R * geometry::so3_exp(-ago_s * w);
    poses_.push_back(
        {scan.t_end - Duration::from_s(ago_s), {R, state_.T_odom_body.p - ago_s * state_.v}});
  }
  sampler_.sample(scan);
  insert(scan);
}

}  // namespace rali::odometry::internal
