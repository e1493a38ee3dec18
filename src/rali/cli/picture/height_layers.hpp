#pragma once

#include <cstdint>
#include <vector>

namespace rali::cli {

/// What lies above each pixel of a map seen from above: which slices of height are occupied.
class HeightLayers {
 public:
  /// @param low_m, high_m  heights outside count as the lowest and the highest slice
  HeightLayers(int width, int height, double low_m, double high_m);

  /// Pixels outside are left out.
  void add(int x, int y, double z_m);

  /// 0: nothing here, 1: upright as a wall. Floors and ceilings, however thick the noise, stay low.
  [[nodiscard]] double strength(int x, int y) const;

  /// Height that gives the colour, 0 to 1 of the range: of upright things the top, else the
  /// lowest slice (the floor below a ceiling).
  [[nodiscard]] double share(int x, int y) const;

 private:
  [[nodiscard]] std::uint64_t slices(int x, int y) const;

  int width_, height_;
  double low_m_, range_m_, slice_m_;
  std::vector<std::uint64_t> slices_;
};

}  // namespace rali::cli
