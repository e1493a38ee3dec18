#pragma once

#include <array>

#include "rali/odometry/robust/matcher.hpp"
#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "recording.hpp"

namespace rali::degeneracy_bench {

/// Accuracy of registration without any prior at one position (algorithms 3.4).
struct Achieved {
  double worst_m = 0.0;     ///< horizontal error at the end, worst of four starts
  bool degenerate = false;  ///< worst_m above the limit
  /// One start converged to a wrong minimum while the opposite one converged correctly: a
  /// convergence failure, not degeneracy.
  bool wrong_minimum = false;
};

/// The map of a drive from true poses and the scan that is matched with it. Sampling, planes and
/// weights are those of preset `robust`.
class TrueMap {
 public:
  explicit TrueMap(const odometry::RobustSettings& settings);

  /// Prepares the scan of a station; points within `mask_m` of another vehicle are left out.
  void look(const Station& station, const sensor::Calibration& calibration, double mask_m);

  /// Inserts the scan of the last look() into the map.
  void insert();

  /// System, evidence and matches of the scan at its true pose.
  [[nodiscard]] odometry::LidarSystem at_truth();

  [[nodiscard]] const std::vector<degeneracy::PlaneEvidence>& evidence() const {
    return matcher_.evidence();
  }

  /// Sum of h^T h over the matched points with h = ((R p) x n, n) in the outer frame about the
  /// body: all points have equal weight, as in Zhang 2016.
  [[nodiscard]] geometry::Mat6 unweighted() const;

  /// Registers from starts 0.1 m ahead, behind, left and right of the true pose.
  [[nodiscard]] Achieved register_from_beside();

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
