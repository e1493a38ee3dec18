#include "rali/drive/offset/lidar_turning.hpp"

#include <algorithm>

#include "rali/odometry/robust/robust_odometry.hpp"

namespace rali::drive {
namespace {

/// A rotation between scans farther apart is not one motion any more.
constexpr double kTurnMax_s = 0.5;

bool is_degenerate(const odometry::ScanResult& result) {
  if (!result.directions) return false;
  return std::any_of(
      result.directions->begin(), result.directions->begin() + 3,
      [](const degeneracy::DirectionInfo& d) { return d.category == degeneracy::Category::kNone; });
}

}  // namespace

LidarTurning::LidarTurning(const odometry::OdometrySettings& settings)
    : odometry_(odometry::make_robust_odometry(settings, sensor::Calibration{}, false)) {}

void LidarTurning::see(const sensor::LidarScan& scan, Executor& executor) {
  if (scan.size() == 0) return;
  FindingList ignored;  // this odometry is only used for its rotation
  const odometry::ScanResult result = odometry_->process(scan, executor, ignored);
  using odometry::TrackState;
  if (is_degenerate(result)) ++degenerate_;
  const bool good = result.state == TrackState::kGood || result.state == TrackState::kWeak;
  ++scans_;
  if (!good) {
    if (result.state != TrackState::kWaiting) ++lost_;
    last_.reset();
    ++piece_;
    return;
  }
  const geometry::Mat3 R = result.T_odom_body.R;
  track_.push_back({result.t, result.T_odom_body.p, piece_});
  if (last_ && result.t > last_->first && seconds_between(last_->first, result.t) < kTurnMax_s) {
    turns_.push_back({last_->first, result.t, geometry::so3_log(last_->second.transpose() * R)});
  }
  last_ = {result.t, R};
}

}  // namespace rali::drive
