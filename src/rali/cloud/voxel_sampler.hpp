#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rali::cloud {

/// Points as three flat arrays of one length.
struct PointSpan {
  const float* x_m = nullptr;
  const float* y_m = nullptr;
  const float* z_m = nullptr;
  std::size_t size = 0;
};

/// Key of the cell that holds a point; cells beyond +-2^20 are clamped to the border cell.
[[nodiscard]] inline std::uint64_t voxel_key(int ix, int iy, int iz) {
  constexpr int kOffset = 1 << 20;
  constexpr int kMax = (1 << 21) - 1;
  const auto clamp = [](int v) {
    const int shifted = v + kOffset;
    return static_cast<std::uint64_t>(shifted < 0 ? 0 : (shifted > kMax ? kMax : shifted));
  };
  return (clamp(ix) << 42) | (clamp(iy) << 21) | clamp(iz);
}

/// floor() to int that is inlined (std::floor is a call on baseline x86-64). |v| must be < 2^30.
[[nodiscard]] inline int floor_to_int(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(static_cast<float>(i) > v);
}

[[nodiscard]] inline int floor_to_int(double v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(static_cast<double>(i) > v);
}

/// Spreads the bits of a key over a table (finaliser of MurmurHash3).
[[nodiscard]] inline std::uint64_t hash_key(std::uint64_t key) {
  key ^= key >> 33;
  key *= 0xff51afd7ed558ccdULL;
  key ^= key >> 33;
  return key;
}

/// Keeps one point per cell of a grid: the one nearest to the cell's centre. The choice does not
/// depend on the order of points (decimation by order can keep 4 of 16 rings); the memory is
/// reused.
class VoxelSampler {
 public:
  /// Cells are cubes of voxel_m. Appends to `out` the indices of the kept points, ascending.
  /// `candidates` empty: all points. Points must be finite and within +-2^20 voxels.
  ///
  /// Range noise affects which point of a cube is kept and biases the kept points towards the
  /// cubes' centres: for drawing and merging, not for estimation. See sample_rays().
  void sample(const PointSpan& points, std::span<const std::uint32_t> candidates, double voxel_m,
              std::vector<std::uint32_t>& out);

  /// Cells are bundles of rays from the origin, 1 to 1.4 spacing_m wide at a surface seen head-on.
  /// The choice of the kept point is therefore independent of its range error. Points in the sensor
  /// frame.
  void sample_rays(const PointSpan& points, std::span<const std::uint32_t> candidates,
                   double spacing_m, std::vector<std::uint32_t>& out);

 private:
  /// An occupied cell: the point and its distance from the cell's centre.
  struct Slot {
    std::uint64_t key;
    std::uint32_t point;
    float distance2;
  };

  static constexpr std::uint64_t kFree = ~std::uint64_t{0};  ///< no key: those have 63 bits

  template <class Scale>
  void run(const PointSpan& points, std::span<const std::uint32_t> candidates, Scale scale,
           std::vector<std::uint32_t>& out);
  void offer(std::uint64_t key, float distance2, std::uint32_t point);
  void prepare(std::size_t n);
  void grow();
  void collect(std::size_t n_points, std::vector<std::uint32_t>& out);

  std::vector<Slot> slots_, old_slots_;  ///< open addressing, at most half full
  std::vector<std::uint32_t> used_;      ///< slots in use
  std::vector<std::uint64_t> chosen_;    ///< one bit per point
};

}  // namespace rali::cloud
