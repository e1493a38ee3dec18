// Walls of a passage, as a measurement of the lateral offset of two vehicles in it.
#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using ranging::LateralOffset;
using ranging::PassageWalls;

namespace {

/// Free distance in the map in that direction, to centimetres. It is walls_far_m if all of that is
/// free, or if a surface is so near that it must be the vehicle's own.
double free_m(const Vec3& p_odom_m, const Vec3& direction, const ranging::FinderSettings& settings,
              const AugmentedFilter& filter) {
  constexpr double kFine_m = 0.02;
  const double far_m = settings.walls_far_m;
  if (filter.surfaces_between(p_odom_m, p_odom_m + far_m * direction) == 0) return far_m;
  double free_m = 0.0;
  double beyond_m = far_m;
  while (beyond_m - free_m > kFine_m) {
    const double middle_m = 0.5 * (free_m + beyond_m);
    const bool wall = filter.surfaces_between(p_odom_m, p_odom_m + middle_m * direction) > 0;
    (wall ? beyond_m : free_m) = middle_m;
  }
  return free_m < settings.walls_own_m ? far_m : free_m;
}

}  // namespace

std::optional<PassageWalls> RangeStage::walls(const AugmentedFilter& filter,
                                              const SE3& T_odom_body) const {
  const std::optional<Vec3> axis = filter.degenerate_axis();
  if (!axis || peers_.empty() || settings_.antennas_body_m.empty()) return std::nullopt;
  return walls_beside(T_odom_body * settings_.antennas_body_m.front(), *axis, filter);
}

/// Walls of the passage at that point of odom, if both are seen. Neighbouring rays make up for
/// single rays that pass through a gap of the map or meet a post.
std::optional<PassageWalls> RangeStage::walls_beside(const Vec3& p_odom_m, const Vec3& axis_odom,
                                                     const AugmentedFilter& filter) const {
  constexpr std::array kSteps{0.0, -1.0, 1.0, -2.0, 2.0};
  const ranging::FinderSettings& s = settings_.ranging.finder;
  const double far_m = s.walls_far_m;
  const Vec3 left = up_odom_.cross(axis_odom).normalized();
  const Vec3 axis = left.cross(up_odom_);
  const auto wall_m = [&](const Vec3& direction) {
    std::array<double, kSteps.size()> met_m;
    std::transform(kSteps.begin(), kSteps.end(), met_m.begin(), [&](double steps) {
      return free_m(p_odom_m + steps * s.walls_every_m * axis, direction, s, filter);
    });
    // The median of the rays that meet a wall, if most of them do.
    std::sort(met_m.begin(), met_m.end());
    const auto met = std::lower_bound(met_m.begin(), met_m.end(), far_m) - met_m.begin();
    return 2 * met > static_cast<std::ptrdiff_t>(met_m.size())
               ? met_m[static_cast<std::size_t>(met) / 2]
               : far_m;
  };
  const PassageWalls walls{axis, wall_m(left), wall_m(-left)};
  if (walls.left_m >= far_m || walls.right_m >= far_m) return std::nullopt;
  return walls;
}

/// Walls beside the peer's antenna, in odom, as reported by the peer at standstill.
std::optional<PassageWalls> RangeStage::walls_of(const LandmarkKey& key) const {
  const auto& [id, antenna] = key;
  const PeerWatch& peer = peers_.at(id);
  const bool reported = peer.at_rest && peer.pose && peer.pose->walls;
  if (!reported || !peer.settings.prior || !first_pose_) return std::nullopt;
  const geometry::Mat3 R_odom_start = start_of(peer);
  PassageWalls walls = *peer.pose->walls;
  walls.axis = R_odom_start * walls.axis;
  const std::vector<Vec3>& antennas_m = peer.settings.antennas_body_m;
  const Vec3 from_first_m =
      R_odom_start * peer.pose->T_start_body.R * (antennas_m[antenna] - antennas_m.front());
  const double left_m = up_odom_.cross(walls.axis).dot(from_first_m);
  walls.left_m -= left_m;
  walls.right_m += left_m;
  return walls;
}

/// The same walls measured again have the same error. So they are used only if sigma is half of
/// that at the last use: bends of the passage hide less, or both see the same width now. While the
/// landmark has a mixture, its slices are bounded by the walls instead.
void RangeStage::measure_lateral_offset(const PairKey& key, Place& place,
                                        const odometry::Moment& now,
                                        AugmentedFilter& filter) const {
  const std::optional<Vec3> axis = filter.degenerate_axis();
  if (place.passage || place.passed || !axis) return;
  const Vec3 p_odom_m = now.T_odom_body * settings_.antennas_body_m[std::get<0>(key)];
  const Vec3 apart = filter.augmented().mean.segment<3>(place.state_index) - p_odom_m;
  const ranging::FinderSettings& s = settings_.ranging.finder;
  const double hidden_m =
      ranging::lateral_offset_in_passage(s, LateralOffset{0.0, 0.0}, apart.norm()).sigma_m;
  const double worth_m = 0.5 * place.lateral_sigma_m;
  if (hidden_m + s.walls_sigma_m > worth_m) return;
  const std::optional<PassageWalls> other = walls_of({std::get<1>(key), std::get<2>(key)});
  if (!other) return;
  const std::optional<PassageWalls> own = walls_beside(p_odom_m, *axis, filter);
  if (!own) return;
  const std::optional<LateralOffset> both = ranging::lateral_offset_by_walls(s, *own, *other);
  if (!both) return;
  const double sigma_m = both->sigma_m + hidden_m;
  if (sigma_m > worth_m) return;
  place.lateral_sigma_m = sigma_m;
  const Vec3 left = up_odom_.cross(own->axis);
  odometry::AugmentedMeasurement row;
  row.d_augmented = odometry::AugmentedStates::Vector::Zero(filter.augmented().size());
  row.d_augmented.segment<3>(place.state_index) = left;
  row.d_pose.tail<3>() = -left.transpose();
  row.residual = both->mean_m - left.dot(apart);
  const double S_m2 = filter.variance(row) + sigma_m * sigma_m;
  if (row.residual * row.residual > s.report_sigmas * s.report_sigmas * S_m2) return;
  filter.apply(row, sigma_m * sigma_m);
}

/// By the walls beside both, or, if the peer reports none, by those beside the own antenna.
std::optional<LateralOffset> RangeStage::lateral_offset_by_walls(
    const LandmarkKey& key, const Vec3& p_odom_m, const Vec3& axis_odom,
    const AugmentedFilter& filter) const {
  const std::optional<PassageWalls> own = walls_beside(p_odom_m, axis_odom, filter);
  if (!own) return std::nullopt;
  const ranging::FinderSettings& s = settings_.ranging.finder;
  const std::optional<PassageWalls> other = walls_of(key);
  const auto both = other ? ranging::lateral_offset_by_walls(s, *own, *other) : std::nullopt;
  return both ? both : ranging::lateral_offset_between_walls(s, *own);
}

}  // namespace rali::vehicle
