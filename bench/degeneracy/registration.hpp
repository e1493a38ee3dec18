#pragma once

#include <array>

#include "rali/odometry/robust/matcher.hpp"
#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "recording.hpp"

namespace rali::degeneracy_bench {

/// What registration without any prior achieves at one place (algorithms 3.4).
struct Achieved {
  double worst_m = 0.0;  ///< horizontal error at the end, worst of four starts
  bool blind = false;    ///< worst_m above the limit
  /// One start fell into a wrong minimum while its opposite came home: a failure to converge, no
  /// blindness.
  bool wrong_minimum = false;
};

/// The true map of a drive and the sweep that is matched with it: sampling, planes and weights
/// are those of preset `robust`, only the poses are true.
class TrueMap {
 public:
  explicit TrueMap(const odometry::RobustSettings& settings);

  /// Takes the sweep of a station; what lies within `mask_m` of another vehicle is left out.
  void look(const Station& station, const sensor::Calibration& calibration, double mask_m);

  /// Puts the sweep of the last look() into the map.
  void insert();

  /// System, evidence and matches of the sweep at its true pose.
  [[nodiscard]] odometry::LidarSystem at_truth();

  [[nodiscard]] const std::vector<degeneracy::PlaneEvidence>& evidence() const {
    return matcher_.evidence();
  }

  /// Sum of h^T h over the matched points with h = ((R p) x n, n) in the outer frame about the
  /// body: every point counts alike, as in Zhang 2016.
  [[nodiscard]] geometry::Mat6 unweighted() const;

  /// Registers from 0.1 m off ahead, behind, left and right.
  [[nodiscard]] Achieved register_from_aside();

 private:
  [[nodiscard]] double error_from(const geometry::Vec3& offset_world_m);
  void fill(const std::vector<std::uint32_t>& indices, const Station& station,
            const sensor::Calibration& calibration, double mask_m, odometry::BodyPoints& out);

  odometry::RobustSettings settings_;
  odometry::ScanSampler sampler_;
  odometry::PlaneMap map_;
  odometry::Matcher matcher_;
  odometry::BodyPoints update_, insert_;
  geometry::SE3 T_world_body_;
  geometry::Vec3 p_body_lidar_ = geometry::Vec3::Zero();
};

}  // namespace rali::degeneracy_bench
