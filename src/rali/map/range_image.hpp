#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// What a keyframe says about one place.
enum class Sight : std::uint8_t {
  kUnknown,  ///< nothing: not looked at, hidden, or the rays are too sparse to tell
  kHit,      ///< a ray came back from it
  kPassed    ///< a ray went through it and on
};

struct SightLimits {
  double range_m = 25.0;
  double margin_m = 0.3;   ///< depth difference that separates the place from what is behind it
  double radius_m = 0.05;  ///< half the size of the place; the passing ray must touch it
  double beside_m = 0.1;   ///< a return this far beside the place ...
  double depth_m = 0.15;   ///< ... and this far before or behind it is still of it
  double thin_m = 0.06;    ///< rays spread wider than this may miss a pole
};

/// The rays of one keyframe as a picture around the LiDAR: rows as many as there are lasers,
/// columns of 0.4 degrees, each pixel the nearest return in it with its exact direction.
class RangeImage {
 public:
  /// Reuses the memory of the picture before.
  void build(const KeyframeView& keyframe);

  /// What the rays say about a place given in the LiDAR frame.
  ///
  /// Passed is said only if a ray touched the place and ended `margin_m` behind it while no
  /// neighbouring ray ended before or at it: beside a silhouette, on a floor or along a wall at
  /// grazing incidence one of the neighbours does, and nothing is said. Nor is such a neighbour a
  /// hit: rows are 2 degrees apart, and the floor before a person says nothing of the person.
  [[nodiscard]] Sight look(const geometry::Vec3& p_lidar_m, const SightLimits& limits) const;

  /// False if look() is kUnknown for every place of a ball around `middle_lidar_m`: it is beyond
  /// the range, above or below all rays, or all rays towards it end before it. True proves nothing.
  [[nodiscard]] bool may_see(const geometry::Vec3& middle_lidar_m, double ball_m,
                             const SightLimits& limits) const;

  /// Mean angle between neighbouring rays of one laser [rad]; infinity without points.
  [[nodiscard]] double ray_spacing_rad() const { return ray_spacing_rad_; }

  [[nodiscard]] int rows() const { return rows_; }

 private:
  struct Pixel {
    float range_m = 0.0F;  ///< 0: no return
    float azimuth_rad = 0.0F, elevation_rad = 0.0F;
  };

  /// A place as a ray of the LiDAR would see it, and the pixels whose rays pass near it.
  struct Aim {
    float range_m = 0.0F, azimuth_rad = 0.0F, elevation_rad = 0.0F;
    float cos_elevation = 1.0F;
    int row_begin = 0, row_end = 0;
    int column = 0, column_reach = 0;  ///< before the margin is added
  };

  static constexpr int kColumns = 900;
  static constexpr int kNeighboursMax = 6;
  /// Each row goes on beyond both its ends, so that no look has to wrap around.
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
  double ray_spacing_rad_ = 0.0;
  std::vector<Pixel> pixels_;  ///< rows of kStride
  std::vector<Pixel> rays_;    ///< scratch: one per point
};

}  // namespace rali::map
