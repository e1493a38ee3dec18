#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/geometry/se3.hpp"

namespace rali::odometry {

struct DriftSettings {
  double epoch_m = 0.5;          ///< travel after which new planes count as a new generation
  double growth = 1.0;           ///< variance added per generation / variance of one registration
  double start_sigma_m = 0.004;  ///< of the first pose in the map that is built from it
  double start_sigma_deg = 0.05;
  double start_tilt_deg = 0.06;      ///< roll and pitch from sparse rings, with gravity known
  double start_tilt_free_deg = 0.5;  ///< the same without inertial data
  double sigma_max_m = 1.0;          ///< local sigma where the LiDAR is degenerate
  double laser_sigma_deg = 0.05;     ///< elevation errors of the lasers, before they are measured
  double tilt_per_m = 0.2;           ///< rate at which these tilt the map with the distance
  double tilt_length_m = 30.0;       ///< over which that rate changes

  template <class V>
  void visit(V& v) {
    v("epoch_m", epoch_m, 0.05, 100.0, "travel after which new planes are a new generation");
    v("growth", growth, 0.0, 100.0, "variance per generation / variance of one registration");
    v("start_sigma_m", start_sigma_m, 0.0, 1.0, "first pose against the map built from it");
    v("start_sigma_deg", start_sigma_deg, 0.0, 10.0, "the same for its heading");
    v("start_tilt_deg", start_tilt_deg, 0.0, 45.0, "the same for its roll and pitch");
    v("start_tilt_free_deg", start_tilt_free_deg, 0.0, 45.0, "and without inertial data");
    v("sigma_max_m", sigma_max_m, 0.01, 100.0, "bound of the local sigma in degenerate directions");
    v("laser_sigma_deg", laser_sigma_deg, 0.0, 2.0,
      "sigma of the elevations of the lasers, before it is measured");
    v("tilt_per_m", tilt_per_m, 0.0, 10.0,
      "sigma of the tilt of the map per metre, as a multiple of that");
    v("tilt_length_m", tilt_length_m, 1.0, 10000.0, "distance over which that rate changes");
  }
};

/// How well gravity determines roll and pitch.
struct Level {
  Eigen::Matrix<double, 3, 2> axes_odom;  ///< two horizontal unit vectors
  Eigen::Matrix2d covariance;             ///< of the tilts about them [rad^2]
  /// Tilt of odom since the first pose, about x and y (map_tilt_rad()).
  Eigen::Vector2d tilt_rad = Eigen::Vector2d::Zero();
};

/// Generation of the planes that constrain a translation.
struct HeldAlong {
  geometry::Vec3 d_odom = geometry::Vec3::UnitX();  ///< unit vector
  double mean_epoch = 0.0;
};

/// How a pose follows the map when a scan is registered with it: the roots of the filter's gain and
/// of its complement (boxplus). Along unobservable directions it does not follow the map; along
/// poorly observable ones it follows over many scans.
struct MapFollowing {
  geometry::Mat6 follows, keeps;

  [[nodiscard]] static MapFollowing all();
  [[nodiscard]] static MapFollowing nothing();
  /// @param P_predicted of the pose before the scan @param information of the LiDAR
  [[nodiscard]] static MapFollowing of(const geometry::Mat6& P_predicted,
                                       const geometry::Mat6& information);
};

/// Error of the map at the vehicle's position, which a filter that treats its map as exact does not
/// model.
///
/// Planes inherit the error of the pose that first observed them. A scan matched with planes of
/// generation e has their error plus its own, and new planes inherit that. A generation lasts for a
/// distance, or until the pose becomes much less certain. Its error is that of the pose that makes
/// its first planes, one scan later: a degenerate scan may come just before a well constrained one.
/// So the error grows with the generations passed, and drops when the vehicle returns to old
/// planes.
///
/// Each translation has the error of the planes that constrain it. After a degenerate stretch the
/// walls may be old, and the niche that ends it new, with the error accumulated in the stretch.
/// Where the LiDAR is degenerate the pose keeps the error of the map that last constrained it. The
/// filter's covariance contains what accumulated since; new planes inherit both. With known
/// gravity, roll and pitch do not drift: the map's error in them is bounded, and so is its effect
/// on positions. A tilt of the map that the accelerometer shows (Level::tilt_rad) is an error of
/// known sign that grew evenly with the distance: its square, with its effect on positions, is part
/// of the result. Covariances are of a common left perturbation T' = Exp(phi, rho) T about odom's
/// origin, so that they add without lever arms. Order rotation, translation.
class Drift {
 public:
  /// @param levelled gravity determines roll and pitch of the first pose
  explicit Drift(const DriftSettings& settings, bool levelled = true);

  /// Generation of planes that are observed for the first time now.
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  /// Newest established generation: of the first map, or the vehicle has since been away from the
  /// place where it ended. Planes of an object that drives along are of later generations.
  [[nodiscard]] double newest_established() const {
    return static_cast<double>(established_) - 1.0;
  }

  /// @param mean_epoch weighted mean generation of the planes matched by this scan.
  /// @param P_local covariance (boxplus) of the pose, the map treated as exact.
  /// @param level nothing: gravity is not known.
  /// @param held translations whose planes may be of other generations than the mean
  /// @param turned what the bend of a degenerate stretch adds to P_local (Bend); zero without one.
  /// Planes of the stretch inherit it when the stretch has ended; until then only the pose has it.
  /// @return covariance (boxplus) of the pose relative to odom's origin.
  geometry::Mat6 update(const geometry::SE3& T_odom_body, double mean_epoch,
                        const geometry::Mat6& P_local, const MapFollowing& following,
                        const std::optional<Level>& level = std::nullopt,
                        std::span<const HeldAlong> held = {},
                        const geometry::Mat6& turned = geometry::Mat6::Zero());

  /// The map's part of the last update's covariance (boxplus).
  [[nodiscard]] const geometry::Mat6& map_error() const { return map_error_; }

  /// When the LiDAR loses a translation, no map constrains the pose there any more. The map error
  /// of the pose becomes part of the filter's covariance, which ranges may correct.
  /// @param axes_odom projector on those translations
  /// @return covariance of the position that is no longer in map_error()
  [[nodiscard]] geometry::Mat3 release(const geometry::SE3& T_odom_body,
                                       const geometry::Mat3& axes_odom);

  /// The map restarts with the present generation, which counts as established however far the
  /// vehicle has come. Otherwise no plane of it could constrain a vehicle whose inertial sensor is
  /// not initialised yet.
  void establish_all() { established_ = begun_odom_m_.size(); }

  /// The pose was put at one of several places in the map: covariance P (boxplus) of the others
  /// about it. From now on a pose has this error wherever it is registered.
  void add_everywhere(const geometry::SE3& T_odom_body, const geometry::Mat6& P);

  /// How far the map has turned since the last call: covariance of a rotation in odom [rad^2]. Each
  /// generation is turned against those it was registered with, by the error of that registration.
  [[nodiscard]] geometry::Mat3 take_rotation();

  /// A new map starts at a pose with covariance P (boxplus): a new generation.
  void add(const geometry::SE3& T_odom_body, const geometry::Mat6& P);

 private:
  [[nodiscard]] geometry::Mat6 error_at(double epoch) const;
  [[nodiscard]] static bool has_grown(const geometry::Mat6& newest, const geometry::Mat6& now);
  void hold_level(const geometry::SE3& T_odom_body, const Level& level);
  void bound_to_unknown();
  void start_epoch(const geometry::SE3& T_odom_body, const geometry::Mat6& error);
  void end_turned();
  [[nodiscard]] geometry::Vec6 bent(const geometry::SE3& T_odom_body, double mean_epoch,
                                    const Level& level) const;
  void establish(const geometry::Vec3& p_odom_m);

  DriftSettings settings_;
  std::uint32_t epoch_ = 0;
  std::vector<geometry::Mat6> D_;  ///< by generation

  struct Turned {
    std::size_t generation = 0;
    geometry::Mat6 P;  ///< as a left perturbation
  };

  std::vector<Turned> turned_;  ///< of the current degenerate stretch
  std::vector<geometry::Vec3>
      begun_odom_m_;  ///< position of the vehicle at the start of each generation
  /// Mean of begun_odom_m_ up to each generation.
  std::vector<geometry::Vec3> middle_odom_m_;
  std::size_t established_ = 1;  ///< number of established generations
  bool unmoved_ = true;          ///< the vehicle has not left its start
  bool unmade_ = false;          ///< the newest generation has no planes yet
  geometry::Mat6 map_error_ = geometry::Mat6::Zero();
  geometry::Mat6 carried_;                            ///< map_error_ as a left perturbation
  geometry::Mat3 rotation_ = geometry::Mat3::Zero();  ///< take_rotation()
};

}  // namespace rali::odometry
