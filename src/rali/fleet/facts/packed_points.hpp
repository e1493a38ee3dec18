#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace rali::fleet {

/// Points in a body frame, one array per coordinate.
struct PointArrays {
  std::vector<float> x_m, y_m, z_m;
  std::vector<std::uint8_t> intensity;  ///< 0 to 255; empty or as many as points

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  void push_back(float x, float y, float z) {
    x_m.push_back(x);
    y_m.push_back(y);
    z_m.push_back(z);
  }
};

/// A point in steps of 1 cm from the body's origin (algorithms_fleet 11.3).
struct PointCode {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint8_t intensity = 0;
};

inline constexpr double kPointStep_m = 0.01;
inline constexpr std::int32_t kPointSteps = 1 << 20;  ///< coordinates are within +-kPointSteps
/// Intensities are sent in steps of 16: enough for a picture, at half the bytes.
inline constexpr int kIntensityStep = 16;

/// Index along a space-filling curve that keeps neighbours together, 21 bits per axis (Morton
/// order).
[[nodiscard]] std::uint64_t curve_place(const PointCode& point);
[[nodiscard]] PointCode point_at(std::uint64_t curve_place);

/// The points of a keyframe as all vehicles have them: rounded to PointCode, ordered by curve
/// index, then by intensity. A mission keeps all of them, so they take about 4 bytes each instead
/// of 13, and copies share them. Immutable.
class PackedPoints {
 public:
  PackedPoints() = default;

  /// Points that are not finite or farther than 10 km are left out. Lists must be of equal length;
  /// an empty list of intensities has none.
  explicit PackedPoints(const PointArrays& points);

  /// In any order, within the bounds of PointCode.
  PackedPoints(std::vector<PointCode> codes, bool with_intensity);

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] bool has_intensity() const { return with_intensity_; }

  [[nodiscard]] std::vector<PointCode> codes() const;

  [[nodiscard]] PointArrays unpacked() const;

  /// Equal for equal points only.
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const;

 private:
  std::size_t size_ = 0;
  bool with_intensity_ = false;
  /// Steps along the curve, seven bits per byte, the lowest first; then two intensities per byte.
  std::shared_ptr<const std::vector<std::uint8_t>> bytes_;
};

}  // namespace rali::fleet
