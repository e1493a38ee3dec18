#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "rali/degeneracy/evidence.hpp"
#include "rali/degeneracy/report.hpp"
#include "rali/degeneracy/support.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::degeneracy {

/// The noise-aware detector (algorithms 3.2, 3.3 with the findings of 3.6).
struct AwareSettings {
  double kappa = 5.0;
  double kappa_supported = 2.0;
  int support_planes = 4;
  int support_clusters = 2;
  double cluster_m = 1.5;
  double full_m = 0.02, none_m = 0.10;
  double full_deg = 0.1, none_deg = 0.5;
  int scans_to_worse = 2, scans_to_better = 5;
  double axis_ratio_min = 4.0;
  /// Without inertial data, points on a person walking along a corridor look like points on a wall,
  /// so a translation without support counts as unobservable. A single scan also gives many planes
  /// whose normals have sigmas of about a degree. Their information by chance is a sum of many
  /// independent terms (Chance).
  bool lidar_alone = false;
  /// Whether support makes a difference: kappa_supported, and walls (walls.hpp). Not at standstill
  /// or without inertial data: passers-by are in several places, too.
  bool trusts_support = true;

  template <class V>
  void visit(V& v) {
    v("kappa", kappa, 0.0, 100.0, "how many times the information expected from noise is removed");
    v("kappa_supported", kappa_supported, 0.0, 100.0,
      "the same for a translation that has support");
    v("support_planes", support_planes, 0, 1000, "planes that support takes");
    v("support_clusters", support_clusters, 0, kClustersMax, "places in which they must be");
    v("cluster_m", cluster_m, 0.1, 10.0, "planes nearer to each other are in one place");
    v("full_m", full_m, 1e-4, 1.0, "sigma below: a direction is fully observable");
    v("none_m", none_m, 1e-3, 10.0, "sigma above: a direction is degenerate");
    v("full_deg", full_deg, 1e-3, 10.0, "sigma below: a rotation is fully observable");
    v("none_deg", none_deg, 1e-2, 90.0, "sigma above: a rotation is degenerate");
    v("scans_to_worse", scans_to_worse, 1, 100, "scans in a row before a class gets worse");
    v("scans_to_better", scans_to_better, 1, 100, "scans in a row before a class gets better");
    v("axis_ratio_min", axis_ratio_min, 1.0, 100.0,
      "horizontal information must differ by this factor, else the last axes are kept");
  }
};

/// Axial (least observable, horizontal or along a slope), lateral (horizontal) and vertical (normal
/// to both), unit, right-handed, in odom. Columns.
using Axes = geometry::Mat3;

/// The physical directions of a scan. @param previous its azimuth is kept if no horizontal
/// direction has clearly less information. @param I information of the scan alone, boxplus order.
[[nodiscard]] Axes physical_axes(const geometry::Mat6& I, const geometry::Vec3& g_odom_mps2,
                                 const geometry::Mat3& R_odom_body, const Axes& previous,
                                 const AwareSettings& settings);

/// The motion along one direction that a scan sees least: a unit translation with the rotation that
/// compensates it best (in a bend: a screw), or a unit rotation with such a translation.
///
/// Roll about the axial direction does not compensate a translation: gravity determines it. In a
/// round pipe the scan has no information on roll; if roll were free, any shift to the side would
/// seem unobservable.
/// @param I information of the scan alone, boxplus order @param k direction, in the order of
/// direction_information() @return in boxplus order
[[nodiscard]] geometry::Vec6 least_motion(const geometry::Mat6& I, std::size_t k,
                                          const geometry::Mat3& R_odom_body, const Axes& axes);

/// Information along the six physical directions after subtracting what noise alone would give:
/// kappa times its expectation, a bound that neither chance nor a few false planes exceed. For a
/// translation it is that of least_motion(): in a bend the normals ahead seem to constrain a shift
/// along the axis, and only the screw shows that they do not. A translation supported by several
/// planes in several clusters needs only kappa_supported, so weak structure is kept. If all planes
/// together do not know it well, the walls that face it may (walls.hpp). Order: axial, lateral,
/// vertical; roll, pitch, yaw. The category is that of this scan alone.
[[nodiscard]] std::array<DirectionInfo, 6> direction_information(
    const geometry::Mat6& I, std::span<const PlaneEvidence> planes,
    const geometry::Mat3& R_odom_body, const Axes& axes, const AwareSettings& settings);

/// Removes the spurious information from a Gauss-Newton system: afterwards the information along
/// each direction is its J, and the step along it that of all planes, or of the walls if J is
/// theirs. Directions that are I-orthogonal to it are unchanged; I stays positive
/// semidefinite (algorithms 2.4).
void remove_spurious(geometry::Mat6& I, geometry::Vec6& b, const geometry::Mat3& R_odom_body,
                     std::span<const DirectionInfo, 6> directions);

/// Categories over time: worse after a few scans, better after more (algorithms 3.3).
class CategoryFilter {
 public:
  explicit CategoryFilter(const AwareSettings& settings) : settings_(settings) {}

  /// Replaces the categories by the filtered ones and sets degenerate, sigma and direction.
  void apply(Report& report);

 private:
  struct Track {
    Category category = Category::kFull;
    int pending = 0;
    bool started = false;
  };

  AwareSettings settings_;
  std::array<Track, 6> tracks_;
};

}  // namespace rali::degeneracy
