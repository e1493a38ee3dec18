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
  double start_tilt_deg = 0.06;      ///< roll and pitch, seen by sparse rings, held by gravity
  double start_tilt_free_deg = 0.5;  ///< the same without inertial data
  double sigma_max_m = 1.0;          ///< local sigma where the LiDAR knows nothing

  template <class V>
  void visit(V& v) {
    v("epoch_m", epoch_m, 0.05, 100.0, "travel after which new planes are a new generation");
    v("growth", growth, 0.0, 100.0, "variance per generation / variance of one registration");
    v("start_sigma_m", start_sigma_m, 0.0, 1.0, "first pose against the map built from it");
    v("start_sigma_deg", start_sigma_deg, 0.0, 10.0, "the same for its heading");
    v("start_tilt_deg", start_tilt_deg, 0.0, 45.0, "the same for its roll and pitch");
    v("start_tilt_free_deg", start_tilt_free_deg, 0.0, 45.0, "and without inertial data");
    v("sigma_max_m", sigma_max_m, 0.01, 100.0, "bound of the local sigma in degenerate directions");
  }
};

/// How well gravity holds roll and pitch.
struct Level {
  Eigen::Matrix<double, 3, 2> axes_odom;  ///< two horizontal unit vectors
  Eigen::Matrix2d covariance;             ///< of the tilts about them [rad^2]
  /// Rotation of odom against the horizontal since the first pose, about x and y (MapTilt).
  Eigen::Vector2d tilt_rad = Eigen::Vector2d::Zero();
};

/// Of which generation the planes are that hold a translation.
struct HeldAlong {
  geometry::Vec3 d_odom = geometry::Vec3::UnitX();  ///< unit vector
  double mean_epoch = 0.0;
};

/// How a pose follows the map when a scan is registered with it: the roots of the filter's gain,
/// and of what is left of one (boxplus). Along what the LiDAR does not see it follows nothing; what
/// the LiDAR sees poorly draws it there over many scans.
struct MapShare {
  geometry::Mat6 follows, keeps;

  [[nodiscard]] static MapShare all();
  [[nodiscard]] static MapShare nothing();
  /// @param P_predicted of the pose before the scan  @param information  of the LiDAR
  [[nodiscard]] static MapShare of(const geometry::Mat6& P_predicted,
                                   const geometry::Mat6& information);
};

/// How wrong the map is where the vehicle is: what a filter that takes its map for granted does
/// not know.
///
/// Planes inherit the error of the pose that saw them first. A scan that matches planes of
/// generation e has their error plus its own; new planes inherit that. A generation lasts some way,
/// or until the pose is known much less well. Its error is that of the pose that makes its first
/// planes, one scan later: a scan that told nothing may come before one that knows where it is. So
/// the error grows with the generations passed, and falls back when the vehicle returns to old
/// planes. Each translation hangs on the planes that tell of it: behind a blind stretch the walls
/// may be old and the niche that ends it new, with the error that the stretch has left in it. Where
/// the LiDAR tells nothing the pose keeps the error of the map that it hung on last; what it has
/// gathered since, the filter knows, and new planes inherit both. Roll and pitch do not wander
/// where gravity is known: there the map's error is bounded, and what it did to positions with it.
/// How far the map has tilted by gravity (Level) is an error of known sign, and grows evenly with
/// the distance: with what it does to positions its square is part of what is stated.
/// Covariances of a common left perturbation T' = Exp(phi, rho) T about odom's origin, so that they
/// add without lever arms. Order rotation, translation.
class Drift {
 public:
  /// @param levelled  gravity holds the first pose
  explicit Drift(const DriftSettings& settings, bool levelled = true);

  /// Generation that planes seen for the first time now belong to.
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  /// Newest generation from whose end the vehicle has been away since, or which is of the first
  /// map: what drives along with a vehicle is of later ones.
  [[nodiscard]] double newest_established() const {
    return static_cast<double>(established_) - 1.0;
  }

  /// @param mean_epoch weighted mean generation of the planes matched by this scan.
  /// @param P_local covariance (boxplus) of the pose, the map taken for granted.
  /// @param level nothing: gravity is not known.
  /// @param held  translations whose planes may be of other generations than the mean
  /// @param turned  what the bend of a degenerate stretch adds to P_local (Bend); zero where there
  /// is none. Planes of the stretch show it to who sees them later, when it has ended: in it the
  /// pose has it by itself.
  /// @return covariance (boxplus) of the pose relative to odom's origin.
  geometry::Mat6 update(const geometry::SE3& T_odom_body, double mean_epoch,
                        const geometry::Mat6& P_local, const MapShare& share,
                        const std::optional<Level>& level = std::nullopt,
                        std::span<const HeldAlong> held = {},
                        const geometry::Mat6& turned = geometry::Mat6::Zero());

  /// What of the last update's covariance is the map's (boxplus).
  [[nodiscard]] const geometry::Mat6& map_error() const { return map_error_; }

  /// Where the LiDAR has lost a translation the pose hangs on no map any more: the error that it
  /// has of one is the filter's from now on, which ranges may correct.
  /// @param axes_odom projector on those translations
  /// @return covariance of the position that is no longer in map_error()
  [[nodiscard]] geometry::Mat3 release(const geometry::SE3& T_odom_body,
                                       const geometry::Mat3& axes_odom);

  /// The map is begun anew with the present generation: it is the first one then, however far the
  /// vehicle has come. Were it held for young, nothing in it could hold a vehicle whose inertial
  /// sensor is not known yet.
  void establish_all() { established_ = begun_odom_m_.size(); }

  /// A new map begins at a pose that is itself uncertain by P (boxplus): a new generation.
  void add(const geometry::SE3& T_odom_body, const geometry::Mat6& P);

 private:
  [[nodiscard]] geometry::Mat6 error_at(double epoch) const;
  [[nodiscard]] static bool has_grown(const geometry::Mat6& newest, const geometry::Mat6& now);
  void hold_level(const geometry::SE3& T_odom_body, const Level& level);
  void begin_epoch(const geometry::SE3& T_odom_body, const geometry::Mat6& error);
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

  std::vector<Turned> turned_;                 ///< of the degenerate stretch that has not ended
  std::vector<geometry::Vec3> begun_odom_m_;   ///< by generation: where the vehicle was
  std::vector<geometry::Vec3> middle_odom_m_;  ///< by generation: mean of these up to it
  std::size_t established_ = 1;                ///< so many of the first generations are
  bool unmoved_ = true;                        ///< the vehicle has not left where it began
  bool unmade_ = false;                        ///< the newest generation has no planes yet
  geometry::Mat6 map_error_ = geometry::Mat6::Zero();
  geometry::Mat6 carried_;  ///< the same as a left perturbation
};

}  // namespace rali::odometry
