#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rali/fleet/facts/facts.hpp"
#include "rali/geometry/types.hpp"

/// Values as whole numbers of small steps, as a fact is sent. Each pair x_code, x_of satisfies
/// x_code(x_of(c)) == c for every c that x_code produces. So an author and its receivers work with
/// the same bits, and a vehicle that forwards a fact sends the same bytes.
namespace rali::fleet {

/// A rotation as the three smaller components of its unit quaternion (w x y z), the largest being
/// positive; components in steps of 2^-bits.
struct RotationCode {
  std::uint8_t largest = 0;
  std::array<std::int32_t, 3> parts{};
  bool operator==(const RotationCode&) const = default;
};

inline constexpr int kPoseBits = 31;   ///< rotations of nodes: within 1e-9 rad
inline constexpr int kRangeBits = 18;  ///< of a range's pose: within 1e-5 rad, 5 um at an antenna

[[nodiscard]] RotationCode rotation_code(const geometry::Mat3& R, int bits);
[[nodiscard]] geometry::Mat3 rotation_of(const RotationCode& code, int bits);

/// A covariance as standard deviations and correlations in steps of 2^-23. Quantised this way it
/// stays positive definite if its correlations are no closer to 1 than a step. Quantised entry by
/// entry it does not.
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

/// A matrix whose small entries are negligible: steps of its largest entry / 32767.
struct ScaledCode {
  float scale = 0.0F;
  std::array<std::int16_t, 9> entries{};
};

[[nodiscard]] ScaledCode scaled_code(const geometry::Mat3& matrix);
[[nodiscard]] geometry::Mat3 scaled_of(const ScaledCode& code);

/// The nearest float, as a double. Never write a cast to float and back instead: gcc 12 drops both
/// casts where two such pairs are adjacent (-O2, vectorised), and the value is not rounded.
[[nodiscard]] double rounded_float(double value);

/// The upper 48 bits of a double. An information matrix needs more than a float: rounding its
/// entries creates spurious information in degenerate directions. With floats this is 0.06 / m^2 at
/// each of a thousand nodes where the other directions have 1e6 / m^2.
[[nodiscard]] double rounded48(double value);
/// Its symmetric part, entries rounded to 48 bits.
[[nodiscard]] geometry::Mat6 rounded_information(const geometry::Mat6& information);

/// Lengths and positions of ranges, in steps of 0.1 mm.
inline constexpr double kRangeStep_m = 1e-4;
[[nodiscard]] std::int64_t range_code(double length_m);
[[nodiscard]] double range_of(std::int64_t code);

}  // namespace rali::fleet
