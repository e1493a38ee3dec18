#pragma once

#include <cstdint>
#include <vector>

namespace rali::cli {

/// Occupied height slices above each pixel of a map seen from above.
class HeightLayers {
 public:
  /// @param low_m, high_m  heights outside count as the lowest or the highest slice
  HeightLayers(int width, int height, double low_m, double high_m);

  /// Pixels outside are left out.
  void add(int x, int y, double z_m);

  /// 0: empty, 1: vertical like a wall. Floors and ceilings get low values, however thick their
  /// noise.
  [[nodiscard]] double strength(int x, int y) const;

  /// Height that determines the colour, 0 to 1 of the range: the top of vertical objects, otherwise
  /// the lowest slice (the floor below a ceiling).
  [[nodiscard]] double fraction(int x, int y) const;

 private:
  [[nodiscard]] std::uint64_t slices(int x, int y) const;

  int width_, height_;
  double low_m_, range_m_, slice_m_;
  std::vector<std::uint64_t> slices_;
};

}  // namespace rali::cli
