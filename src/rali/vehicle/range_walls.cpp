// Walls of a passage, as a measure of how far aside of each other two vehicles stand in it.
#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;
using odometry::SideFilter;
using ranging::Aside;
using ranging::PassageWalls;

namespace {

/// As far as the map is empty that way, to centimetres; walls_far_m if it is all the way, or if
/// something is so near that it must be the vehicle's own.
double free_m(const Vec3& p_odom_m, const Vec3& direction, const ranging::FinderSettings& settings,
              const SideFilter& filter) {
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

std::optional<PassageWalls> RangeStage::walls(const SideFilter& filter,
                                              const SE3& T_odom_body) const {
  const std::optional<Vec3> axis = filter.blind_axis();
  if (!axis || peers_.empty() || settings_.antennas_body_m.empty()) return std::nullopt;
  return walls_beside(T_odom_body * settings_.antennas_body_m.front(), *axis, filter);
}

/// Of the passage at that point of odom, if both are seen: where single rays go through a gap of
/// the map, or meet a post, those beside them tell.
std::optional<PassageWalls> RangeStage::walls_beside(const Vec3& p_odom_m, const Vec3& axis_odom,
                                                     const SideFilter& filter) const {
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
    // The middle of those that meet a wall, most of them.
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

/// Beside the peer's antenna, in odom, as it told where it stands.
std::optional<PassageWalls> RangeStage::walls_of(const PlaceKey& key) const {
  const auto& [id, antenna] = key;
  const PeerWatch& peer = peers_.at(id);
  const bool told = peer.at_rest && peer.pose && peer.pose->walls;
  if (!told || !peer.settings.prior || !first_pose_) return std::nullopt;
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

/// The same walls seen again are the same error: only where they tell twice as well as when they
/// told last, since the passage's bends hide less or both see the same width now. While slices of
/// the place are held open, they are told to those.
void RangeStage::measure_aside(const PairKey& key, Place& place, const odometry::Moment& now,
                               SideFilter& filter) const {
  const std::optional<Vec3> axis = filter.blind_axis();
  if (place.passage || place.passed || !axis) return;
  const Vec3 p_odom_m = now.T_odom_body * settings_.antennas_body_m[std::get<0>(key)];
  const Vec3 apart = filter.side().mean.segment<3>(place.side) - p_odom_m;
  const ranging::FinderSettings& s = settings_.ranging.finder;
  const double hidden_m = ranging::aside_in_passage(s, Aside{0.0, 0.0}, apart.norm()).sigma_m;
  const double worth_m = 0.5 * place.aside_sigma_m;
  if (hidden_m + s.walls_sigma_m > worth_m) return;
  const std::optional<PassageWalls> other = walls_of({std::get<1>(key), std::get<2>(key)});
  if (!other) return;
  const std::optional<PassageWalls> own = walls_beside(p_odom_m, *axis, filter);
  if (!own) return;
  const std::optional<Aside> both = ranging::aside_by_walls(s, *own, *other);
  if (!both) return;
  const double sigma_m = both->sigma_m + hidden_m;
  if (sigma_m > worth_m) return;
  place.aside_sigma_m = sigma_m;
  const Vec3 left = up_odom_.cross(own->axis);
  odometry::SideMeasurement row;
  row.d_side = odometry::SideStates::Vector::Zero(filter.side().size());
  row.d_side.segment<3>(place.side) = left;
  row.d_pose.tail<3>() = -left.transpose();
  row.residual = both->mean_m - left.dot(apart);
  const double S_m2 = filter.variance(row) + sigma_m * sigma_m;
  if (row.residual * row.residual > s.tell_sigmas * s.tell_sigmas * S_m2) return;
  filter.apply(row, sigma_m * sigma_m);
}

/// By those beside both, or, where the peer tells of none, by those beside the own antenna.
std::optional<Aside> RangeStage::aside_by_walls(const PlaceKey& key, const Vec3& p_odom_m,
                                                const Vec3& axis_odom,
                                                const SideFilter& filter) const {
  const std::optional<PassageWalls> own = walls_beside(p_odom_m, axis_odom, filter);
  if (!own) return std::nullopt;
  const ranging::FinderSettings& s = settings_.ranging.finder;
  const std::optional<PassageWalls> other = walls_of(key);
  const auto both = other ? ranging::aside_by_walls(s, *own, *other) : std::nullopt;
  return both ? both : ranging::aside_between_walls(s, *own);
}

}  // namespace rali::vehicle
