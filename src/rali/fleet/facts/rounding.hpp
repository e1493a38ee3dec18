#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rali/fleet/facts/facts.hpp"
#include "rali/geometry/types.hpp"

/// Values as whole numbers of small steps: what is told of a fact. Each pair x_code, x_of satisfies
/// x_code(x_of(c)) == c for every c that x_code makes: an author and those whom he tells work with
/// the same bits, and who passes a fact on sends the same bytes.
namespace rali::fleet {

/// A rotation as the three smaller parts of its unit quaternion (w x y z), the largest being
/// positive; parts in steps of 2^-bits.
struct RotationCode {
  std::uint8_t largest = 0;
  std::array<std::int32_t, 3> parts{};
  bool operator==(const RotationCode&) const = default;
};

inline constexpr int kPoseBits = 31;   ///< rotations of nodes: within 1e-9 rad
inline constexpr int kRangeBits = 18;  ///< of a range's pose: within 1e-5 rad, 5 um at an antenna

[[nodiscard]] RotationCode rotation_code(const geometry::Mat3& R, int bits);
[[nodiscard]] geometry::Mat3 rotation_of(const RotationCode& code, int bits);

/// A covariance as standard deviations and correlations in steps of 2^-23. Rounded this way it
/// stays positive where its correlations are no closer to 1 than that; rounded entry by entry it
/// does not.
template <int N>
struct CovarianceCode {
  std::array<float, N> sigma{};
  std::array<std::int32_t, N*(N - 1) / 2> correlation{};
};

template <int N>
using SquareMatrix = Eigen::Matrix<double, N, N>;

template <int N>
[[nodiscard]] CovarianceCode<N> covariance_code(const SquareMatrix<N>& covariance);
template <int N>
[[nodiscard]] SquareMatrix<N> covariance_of(const CovarianceCode<N>& code);

/// A matrix whose small entries do not matter: steps of its largest entry / 32767.
struct ScaledCode {
  float scale = 0.0F;
  std::array<std::int16_t, 9> entries{};
};

[[nodiscard]] ScaledCode scaled_code(const geometry::Mat3& matrix);
[[nodiscard]] geometry::Mat3 scaled_of(const ScaledCode& code);

/// The nearest float, as a double. Never write a cast to float and back instead: gcc 12 leaves both
/// out where two such pairs stand side by side (-O2, vectorised), and the value stays as it was.
[[nodiscard]] double rounded_float(double value);

/// The upper 48 bits of a double. An information matrix needs more than a float: rounding its
/// entries invents information in blind directions, a float's 0.06 / m^2 at each of a thousand
/// nodes where the others have 1e6 / m^2.
[[nodiscard]] double rounded48(double value);
/// Its symmetric part, entries rounded to 48 bits.
[[nodiscard]] geometry::Mat6 rounded_information(const geometry::Mat6& information);

/// A point in steps of 1 cm from the body's origin (algorithms_fleet 11.3).
struct PointCode {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint8_t intensity = 0;
};

inline constexpr double kPointStep_m = 0.01;
inline constexpr std::int32_t kPointSteps = 1 << 20;  ///< coordinates are within +-kPointSteps
/// Along a curve that keeps neighbours together, 21 bits per axis (Morton's Z order).
[[nodiscard]] std::uint64_t curve_place(const PointCode& point);
[[nodiscard]] PointCode point_at(std::uint64_t curve_place);
/// All points, by their place on the curve, equal places by intensity.
[[nodiscard]] std::vector<PointCode> point_codes(const KeyframePoints& points);
void points_of(const std::vector<PointCode>& codes, KeyframePoints& out);

/// Lengths and places of ranges, in steps of 0.1 mm.
inline constexpr double kRangeStep_m = 1e-4;
[[nodiscard]] std::int64_t range_code(double length_m);
[[nodiscard]] double range_of(std::int64_t code);

/// Intensities are told in steps of 16: enough for a picture, and they take half the bytes.
inline constexpr int kIntensityStep = 16;

}  // namespace rali::fleet
