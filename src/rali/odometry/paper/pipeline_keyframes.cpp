#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "rali/odometry/paper/pipeline.hpp"

namespace rali::odometry::paper {

using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

/// At the end of a degenerate stretch a keyframe applies the ranges since the last one, so it is
/// due earlier.
double PaperOdometry::keyframe_due_s() const {
  constexpr double kAtEnd = 0.25;
  if (degenerate_ended_) return kAtEnd * settings_.keyframe_s;
  return degenerate_odom_ ? settings_.keyframe_s : 0.0;
}

void PaperOdometry::keyframe_if_wanted(const LidarScan& scan, FindingList& findings,
                                       ScanResult& out) {
  if (features_.size() < 3) return;
  const double overlap = keyframer_.overlap(cloud_lidar_, extractor_.thinned(), out.T_odom_body);
  const bool due = keyframer_.is_due(scan.t_end, out.T_odom_body, keyframe_due_s());
  if (!keyframer_.wants(overlap) && !due) return;
  if (corrector_ != nullptr) {
    const KeyframeInertia inertia{predicted_, guess_.motion(),
                                  has_imu_ ? guess_.since_keyframe() : nullptr};
    if (const auto move = corrector_->at_keyframe(out, inertia)) take_move(*move, out);
    guess_.start_keyframe();
  }
  map_error_.add_keyframe(out.T_odom_body, settings_.registration_fraction * out.lidar_information);
  out.keyframe = keyframer_.make(scan, cloud_lidar_, extractor_.thinned(), out);
  std::vector<PointNormal> stored;
  stored.reserve(features_.size());
  const Eigen::Matrix3f R = T_body_lidar_.R.cast<float>();
  const geometry::Vec3f p = T_body_lidar_.p.cast<float>();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const geometry::Vec3f at(features_.x_m[i], features_.y_m[i], features_.z_m[i]);
    const geometry::Vec3f n(features_.nx[i], features_.ny[i], features_.nz[i]);
    stored.push_back({R * at + p, R * n});
  }
  submap_.add_keyframe(out.T_odom_body, std::move(stored));
  if (submap_.forgotten() > 0) {
    note(findings, reported_forgets_, "odometry.keyframes_full", scan.t_end,
         fmt::format("more than {} keyframes: the oldest leave the odometry's map",
                     settings_.keyframes_kept_max),
         "places seen first are new when they are seen again",
         "Raise odometry.paper.keyframes_kept_max.");
  }
}

void PaperOdometry::take_move(const KeyframeMove& move, ScanResult& out) {
  submap_.move_newest(move.earlier);
  if (!move.earlier.empty()) keyframer_.move_last(move.earlier.back());
  const SE3 T_new_old = move.T_odom_body * out.T_odom_body.inverse();
  guess_.move(T_new_old);
  if (move.motion && has_imu_) guess_.set_motion(*move.motion);
  last_registered_ = T_new_old * last_registered_;
  if (stands_at_) stands_at_ = T_new_old * *stands_at_;
  out.T_odom_body = guess_.T_odom_body();
  if (move.known) {
    guess_.know_along(*move.known);
    map_error_.know_along(move.known->e_odom, move.known->place_sigma_m);
    out.T_odom_body = guess_.T_odom_body();
    covariance_ = guess_.covariance() + map_error_.at(out.T_odom_body);
    out.covariance = covariance_;
  }
  out.v_odom_mps = guess_.v_odom_body_mps();
}

/// Reports once when the position is lost, and again whenever it is four times worse.
void PaperOdometry::report_if_lost(Time t, FindingList& findings) {
  constexpr double kWorse = 4.0;
  constexpr double kBetter = 0.5;
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver(
      geometry::Mat3(covariance_.bottomRightCorner<3, 3>()), Eigen::EigenvaluesOnly);
  const double sigma_m = std::sqrt(std::max(0.0, solver.eigenvalues().z()));
  if (sigma_m < kBetter * settings_.lost_m) reported_lost_m_ = 0.0;
  const double limit_m = std::max(settings_.lost_m, kWorse * reported_lost_m_);
  if (!(sigma_m > limit_m)) return;
  reported_lost_m_ = sigma_m;
  Finding f;
  f.id = "odometry.lost";
  f.severity = Severity::kError;
  f.t = t;
  f.value = sigma_m;
  f.limit = settings_.lost_m;
  f.text = degenerate_odom_
               ? fmt::format(
                     "lost: the LiDAR does not constrain the position along the passage and "
                     "no range corrects it, sigma {:.1f} m",
                     sigma_m)
               : fmt::format("lost: the position is known to {:.1f} m only", sigma_m);
  f.effect = "the map is stretched or shortened here by as much";
  f.remedy =
      "Let another vehicle stand still in line of sight with a range sensor, or use preset robust.";
  findings.push_back(std::move(f));
}

void PaperOdometry::note(FindingList& findings, bool& reported, const char* id, Time t,
                         std::string text, std::string effect, std::string remedy) {
  if (reported) return;
  reported = true;
  Finding f;
  f.id = id;
  f.t = t;
  f.text = std::move(text);
  f.effect = std::move(effect);
  f.remedy = std::move(remedy);
  findings.push_back(std::move(f));
}

std::uint64_t PaperOdometry::state_hash() const {
  std::uint64_t h = 0xcbf29ce484222325ULL;  // FNV-1a over 64-bit words
  const auto mix = [&h](std::uint64_t v) { h = (h ^ v) * 0x100000001b3ULL; };
  const auto mix_real = [&mix](double v) { mix(std::bit_cast<std::uint64_t>(v)); };
  const SE3 T = guess_.T_odom_body();
  for (int k = 0; k < 9; ++k) mix_real(T.R.data()[k]);
  for (int k = 0; k < 3; ++k) {
    mix_real(T.p(k));
    mix_real(guess_.v_odom_body_mps()(k));
    mix_real(guess_.bias().gyro_radps(k));
    mix_real(guess_.bias().accel_mps2(k));
  }
  for (int k = 0; k < 36; ++k) mix_real(covariance_.data()[k]);
  mix(submap_.keyframes());
  mix(submap_.points());
  mix(static_cast<std::uint64_t>(t_last_.ns));
  return h;
}

}  // namespace rali::odometry::paper
