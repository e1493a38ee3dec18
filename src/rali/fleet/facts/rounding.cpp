#include "rali/fleet/facts/rounding.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include <Eigen/Geometry>

namespace rali::fleet {

namespace {

using geometry::Mat3;
using geometry::Mat6;

constexpr double kCorrelationSteps = 8388607.0;
constexpr double kScaledSteps = 32767.0;

std::array<double, 4> quaternion(const Mat3& R) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  return {q.w(), q.x(), q.y(), q.z()};
}

RotationCode code_once(const std::array<double, 4>& q, double steps) {
  std::array<std::int64_t, 4> rounded{};
  for (std::size_t i = 0; i < 4; ++i) rounded[i] = std::llround(q[i] * steps);
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(rounded[i]) > std::abs(rounded[largest])) largest = i;
  }
  RotationCode code{static_cast<std::uint8_t>(largest), {}};
  const std::int64_t sign = q[largest] < 0.0 ? -1 : 1;
  std::size_t at = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i != largest) code.parts[at++] = static_cast<std::int32_t>(sign * rounded[i]);
  }
  return code;
}

}  // namespace

Mat3 rotation_of(const RotationCode& code, int bits) {
  const double step = std::ldexp(1.0, -bits);
  std::array<double, 4> q{};
  double rest = 1.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == code.largest) continue;
    q[i] = code.parts[at++] * step;
    rest -= q[i] * q[i];
  }
  q[code.largest & 3U] = std::sqrt(std::max(rest, 0.0));
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

RotationCode rotation_code(const Mat3& R, int bits) {
  const double steps = std::ldexp(1.0, bits);
  RotationCode code = code_once(quaternion(R), steps);
  // If two components are almost equal, rounding can make the other one the largest: the code is
  // decoded and encoded again until it no longer changes.
  constexpr int kTries = 16;
  for (int k = 0; k < kTries; ++k) {
    const RotationCode again = code_once(quaternion(rotation_of(code, bits)), steps);
    if (again == code) break;
    code = again;
  }
  return code;
}

template <int N>
CovarianceCode<N> covariance_code(const SquareMatrix<N>& covariance) {
  CovarianceCode<N> code;
  for (int i = 0; i < N; ++i) {
    code.sigma[static_cast<std::size_t>(i)] =
        static_cast<float>(rounded_float(std::sqrt(std::max(covariance(i, i), 0.0))));
  }
  std::size_t at = 0;
  for (int i = 1; i < N; ++i) {
    for (int j = 0; j < i; ++j, ++at) {
      const double sigmas = static_cast<double>(code.sigma[static_cast<std::size_t>(i)]) *
                            static_cast<double>(code.sigma[static_cast<std::size_t>(j)]);
      if (!(sigmas > 0.0)) continue;
      const double both = 0.5 * (covariance(i, j) + covariance(j, i)) / sigmas;
      code.correlation[at] =
          static_cast<std::int32_t>(std::lround(std::clamp(both, -1.0, 1.0) * kCorrelationSteps));
    }
  }
  return code;
}

template <int N>
SquareMatrix<N> covariance_of(const CovarianceCode<N>& code) {
  SquareMatrix<N> covariance;
  std::size_t at = 0;
  for (int i = 0; i < N; ++i) {
    const auto sigma_i = static_cast<double>(code.sigma[static_cast<std::size_t>(i)]);
    for (int j = 0; j < i; ++j, ++at) {
      const double sigmas = sigma_i * static_cast<double>(code.sigma[static_cast<std::size_t>(j)]);
      covariance(i, j) = covariance(j, i) =
          sigmas * (static_cast<double>(code.correlation[at]) / kCorrelationSteps);
    }
    covariance(i, i) = sigma_i * sigma_i;
  }
  return covariance;
}

template CovarianceCode<3> covariance_code<3>(const SquareMatrix<3>&);
template CovarianceCode<6> covariance_code<6>(const SquareMatrix<6>&);
template CovarianceCode<9> covariance_code<9>(const SquareMatrix<9>&);
template SquareMatrix<3> covariance_of<3>(const CovarianceCode<3>&);
template SquareMatrix<6> covariance_of<6>(const CovarianceCode<6>&);
template SquareMatrix<9> covariance_of<9>(const CovarianceCode<9>&);

ScaledCode scaled_code(const Mat3& matrix) {
  ScaledCode code;
  code.scale = static_cast<float>(rounded_float(matrix.cwiseAbs().maxCoeff()));
  if (!(code.scale > 0.0F)) return code;
  for (int k = 0; k < 9; ++k) {
    const double part = matrix(k / 3, k % 3) / static_cast<double>(code.scale);
    code.entries[static_cast<std::size_t>(k)] =
        static_cast<std::int16_t>(std::lround(std::clamp(part, -1.0, 1.0) * kScaledSteps));
  }
  return code;
}

Mat3 scaled_of(const ScaledCode& code) {
  Mat3 matrix;
  for (int k = 0; k < 9; ++k) {
    matrix(k / 3, k % 3) =
        static_cast<double>(code.scale) *
        (static_cast<double>(code.entries[static_cast<std::size_t>(k)]) / kScaledSteps);
  }
  return matrix;
}

double rounded_float(double value) {
  const volatile float narrow = static_cast<float>(value);
  return static_cast<double>(narrow);
}

double rounded48(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return std::bit_cast<double>((bits + 0x8000U) & ~std::uint64_t{0xFFFF});
}

Mat6 rounded_information(const Mat6& information) {
  Mat6 out;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      out(i, j) = out(j, i) = rounded48(0.5 * (information(i, j) + information(j, i)));
    }
  }
  return out;
}

std::int64_t range_code(double length_m) { return std::llround(length_m / kRangeStep_m); }

double range_of(std::int64_t code) { return static_cast<double>(code) * kRangeStep_m; }

}  // namespace rali::fleet
