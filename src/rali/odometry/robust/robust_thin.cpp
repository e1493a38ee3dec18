#include <cmath>

#include "rali/degeneracy/support.hpp"
#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::SE3;

std::array<bool, 3> RobustOdometry::closed() const {
  return {degenerate_[0] || thin_, degenerate_[1], degenerate_[2]};
}

/// Observability at the final pose of the scan. A rejected registration has few matches and little
/// information; storing it too would make the right pose impossible.
void RobustOdometry::remember_seen(const UpdateResult& done) {
  axes_ = done.axes;
  lidar_known_ = done.known;
  remember_blindness(done);
  follow_bend(done);
}

/// A direction becomes degenerate at once, and observable again only after several scans in a row:
/// one of many scans has information by chance.
void RobustOdometry::remember_blindness(const UpdateResult& done) {
  if (done.matches < settings_.update.matches_min) return;
  const bool was_degenerate = degenerate_[0];
  for (std::size_t k = 0; k < 3; ++k) {
    seeing_scans_[k] = done.sees[k] ? seeing_scans_[k] + 1 : 0;
    if (!done.sees[k]) degenerate_[k] = true;
    if (seeing_scans_[k] >= settings_.aware.scans_to_better) degenerate_[k] = false;
  }
  // A short glimpse does not end a degenerate stretch.
  if (was_degenerate && !degenerate_[0]) t_seen_ = state_.t;
  const bool glimpse = t_seen_ && (state_.t - *t_seen_).s() < kGlimpse_s;
  if (!was_degenerate && degenerate_[0] && !glimpse) t_degenerate_ = state_.t;
}

/// The newest scan meets too few planes of the map to be registered, but the inertial data know its
/// pose. Left out, it would keep the map from growing to where the vehicle drives: sparse rings see
/// hardly a plane in the open from a single place. A scan that lies beside the planes it meets is
/// not such a scan: there the pose is wrong.
bool RobustOdometry::is_on_new_ground() const {
  constexpr double kKnown_m = 0.1;  // half of the smallest cell of the map
  const double variance_m2 = state_.P.block<3, 3>(kPos, kPos).diagonal().maxCoeff();
  return inertial_ && variance_m2 < kKnown_m * kKnown_m &&
         !is_rotation_uncertain(state_.P.topLeftCorner<6, 6>()) &&
         matcher_.overlap(map_, state_.T_odom_body).beside() < settings_.update.matches_min;
}

/// As of a scan that meets no plane: the directions seen last remain.
UpdateResult RobustOdometry::rejected() const {
  UpdateResult out;
  out.axes = axes_;
  return out;
}

/// Something covers the LiDAR (cover.hpp). Only of a scan that fits poorly is it asked.
bool RobustOdometry::is_covered(const FilterState& predicted, const UpdateResult& done) const {
  constexpr double kPoor = 0.6;  // of the usual fit
  return done.fit < kPoor * usual_fit_ && cover_.covers(points_, predicted.T_odom_body);
}

namespace {

/// Whether the LiDAR moves the pose along the axis beyond the predicted covariance: either the
/// observed object moves, or the inertial sensor is wrong. Only the LiDAR's constraint can be left
/// out.
bool contradicts(const FilterState& predicted, const geometry::Vec3& axis,
                 const UpdateResult& done) {
  constexpr double kSigmas = 3.0;
  const double shift_m = axis.dot(done.lidar_shift.tail<3>());
  const double variance_m2 =
      axis.dot(predicted.P.block<3, 3>(kPos, kPos) * axis) + std::pow(done.directions[0].sigma, 2);
  return shift_m * shift_m > kSigmas * kSigmas * variance_m2;
}

}  // namespace

/// If only few points in few clusters constrain the weakest direction, they may belong to a cart or
/// a person that moves along, or to its trail in the map. Walls and niches differ: their planes are
/// established (the vehicle has moved on since it first saw them), they fit in one position only,
/// and they do not contradict the inertial sensor. Otherwise the constraint is ignored and the
/// direction is degenerate in this scan.
void RobustOdometry::refuse_thin_hold(const FilterState& predicted, const SE3& start,
                                      UpdateResult& done) {
  constexpr double kMany = 0.1;                      // of the scan's points: a cart covers fewer
  constexpr int kPlaces = degeneracy::kClustersMax;  // a cart or person has fewer clusters
  constexpr double kStep_m = 0.4;                    // half a cell of the map
  constexpr double kElsewhere = 0.5;                 // of the information here
  if (!done.sees[0] || done.matches < settings_.update.matches_min) return;
  const geometry::Vec3 axis = done.axes.col(0);
  const auto facing = static_cast<double>(matcher_.points_facing(map_, axis));
  if (facing > kMany * static_cast<double>(matcher_.size())) return;
  if (done.directions[0].clusters >= kPlaces) return;
  const Hold hold =
      matcher_.hold_along(map_, state_.T_odom_body, axis, kStep_m, drift_.newest_established());
  const double none_m = settings_.aware.none_m;
  const bool known = hold.here > 1.0 / (none_m * none_m);
  const bool fits = hold.elsewhere < kElsewhere * hold.here;
  if (known && fits && !contradicts(predicted, axis, done)) return;
  thin_ = true;
  state_ = predicted;
  done = update_with_scan(state_, matcher_, map_, start, settings_, axes_, closed(), true);
}

}  // namespace rali::odometry::internal
