#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// Evidence of a keyframe about one place.
enum class Sight : std::uint8_t {
  kUnknown,  ///< not in view, hidden, or the rays are too sparse
  kHit,      ///< a ray returned from it
  kPassed    ///< a ray passed through it
};

struct SightLimits {
  double range_m = 25.0;
  double margin_m = 0.3;   ///< depth difference that separates the place from surfaces behind it
  double radius_m = 0.05;  ///< half the size of the place; a passing ray must touch it
  double beside_m = 0.1;   ///< a return this far beside the place ...
  double depth_m = 0.15;   ///< ... and this far before or behind it still belongs to it
  double thin_m = 0.06;    ///< rays spread wider than this may miss a pole
};

/// The rays of one keyframe as an image around the LiDAR: one row per laser, columns of 0.4
/// degrees, each pixel the nearest return in it with its exact direction.
class RangeImage {
 public:
  /// Reuses the memory of the previous image.
  void build(const KeyframeView& keyframe);

  /// Evidence of the rays about a place given in the LiDAR frame.
  ///
  /// kPassed needs a ray that touched the place and ended `margin_m` behind it, while no
  /// neighbouring ray ended before or at it. Beside a silhouette, on a floor or along a wall at
  /// grazing incidence one of the neighbours does, and the result is kUnknown. Such a neighbour is
  /// no hit either: rows are 2 degrees apart, and the floor in front of a person is no return from
  /// the person.
  [[nodiscard]] Sight look(const geometry::Vec3& p_lidar_m, const SightLimits& limits) const;

  /// False if look() is kUnknown for every place of a ball around `middle_lidar_m`: it is beyond
  /// the range, above or below all rays, or all rays towards it end before it. True is no
  /// guarantee.
  [[nodiscard]] bool may_see(const geometry::Vec3& middle_lidar_m, double ball_m,
                             const SightLimits& limits) const;

  [[nodiscard]] int rows() const { return rows_; }

 private:
  struct Pixel {
    float range_m = 0.0F;  ///< 0: no return
    float azimuth_rad = 0.0F, elevation_rad = 0.0F;
  };

  /// Direction and range of a place from the LiDAR, and the pixels whose rays pass near it.
  struct Aim {
    float range_m = 0.0F, azimuth_rad = 0.0F, elevation_rad = 0.0F;
    float cos_elevation = 1.0F;
    int row_begin = 0, row_end = 0;
    int column = 0, column_reach = 0;  ///< before the margin is added
  };

  static constexpr int kColumns = 900;
  static constexpr int kNeighboursMax = 6;
  /// Each row is repeated beyond both its ends, so that no access has to wrap around.
  static constexpr int kStride = kColumns + 2 * kNeighboursMax;

  void fit(const KeyframeView& keyframe);
  void repeat_ends();
  [[nodiscard]] bool aim_at(const geometry::Vec3f& p_lidar_m, float range_m, float radius_m,
                            Aim& aim) const;
  [[nodiscard]] bool reaches(const Aim& aim) const;
  [[nodiscard]] static float miss_m(const Pixel& pixel, const Aim& aim);
  [[nodiscard]] static int reach(float radius_m, float range_m, float pitch_rad);
  [[nodiscard]] int row_of(float elevation_rad) const;
  [[nodiscard]] static int column_of(float azimuth_rad);

  int rows_ = 0;
  float elevation_min_rad_ = 0.0F;
  float row_pitch_rad_ = 1.0F;
  double ray_spacing_rad_ =
      0.0;                     ///< mean, between neighbours of one laser; infinite without points
  std::vector<Pixel> pixels_;  ///< rows of kStride
  std::vector<Pixel> rays_;    ///< scratch: one per point
};

}  // namespace rali::map
