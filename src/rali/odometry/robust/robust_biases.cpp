#include <algorithm>

#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Vec3;

namespace {

/// A bias is rejected beyond this many sigma of its prior.
constexpr double kBiasSigmas = 3.0;

}  // namespace

/// A bias estimate larger than any such sensor has is caused by contradictory data. The bias is
/// kept, and the noise is increased until the contradiction is gone.
void RobustOdometry::refuse_biases(const Vec3& gyro_before, const Vec3& accel_before,
                                   FindingList& findings) {
  constexpr double kBoost = 1.2;
  constexpr double kBoostMax = 10.0;
  const InitialisationSettings& init = settings_.initialisation;
  const auto leaves = [](const Vec3& now, const Vec3& before, double limit) {
    return now.norm() > limit && now.norm() > before.norm();
  };
  const bool gyro =
      leaves(state_.gyro_bias_radps, gyro_before, kBiasSigmas * init.gyro_bias_sigma_radps);
  const bool accel =
      leaves(state_.accel_bias_mps2, accel_before, kBiasSigmas * init.accel_bias_sigma_mps2);
  if (!gyro && !accel) return;
  if (gyro) state_.gyro_bias_radps = gyro_before;
  if (accel) state_.accel_bias_mps2 = accel_before;
  noise_boost_ = std::min(kBoostMax, kBoost * noise_boost_);
  if (!refusal_) refusal_ = Refusal{state_.t, state_.t, gyro};
  refusal_->last = state_.t;
  constexpr double kLongest_s = 30.0;  // one that goes on is reported in parts
  if (seconds_between(refusal_->begin, refusal_->last) > kLongest_s) report_refusal(findings);
}

/// A contradiction ends once no bias was refused for a while; the next one counts separately.
void RobustOdometry::end_refusal(Time now, FindingList& findings) {
  constexpr double kOver_s = 2.0;
  if (refusal_ && seconds_between(refusal_->last, now) > kOver_s) report_refusal(findings);
}

void RobustOdometry::report_refusal(FindingList& findings) {
  const InitialisationSettings& init = settings_.initialisation;
  Finding f;
  f.id = "odometry.bias_refused";
  f.severity = Severity::kWarning;
  f.t = refusal_->begin;
  f.t_end = refusal_->last;
  f.text = fmt::format(
      "LiDAR and inertial data contradict each other by more than a bias: {} would pass {:.3f} {}",
      refusal_->gyro ? "the gyro's" : "the accelerometer's",
      kBiasSigmas * (refusal_->gyro ? init.gyro_bias_sigma_radps : init.accel_bias_sigma_mps2),
      refusal_->gyro ? "rad/s" : "m/s2");
  f.effect = fmt::format("inertial data count less for {:.1f} s",
                         seconds_between(refusal_->begin, refusal_->last));
  f.remedy = "Check units, extrinsics and time offset with rali doctor.";
  findings.push_back(f);
  refusal_.reset();
}

void RobustOdometry::finish(FindingList& findings) {
  if (refusal_) report_refusal(findings);
  cover_.finish(findings);
  if (lift_.rides()) findings.push_back(lift_finding(lift_.height()));
}

}  // namespace rali::odometry::internal
