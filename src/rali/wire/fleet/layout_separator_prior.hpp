#pragma once

#include <Eigen/LU>

#include "rali/fleet/messages/separator_prior.hpp"
#include "rali/wire/fleet/layout_messages.hpp"

/// A separator prior is encoded with all its digits: it replaces hours of facts, and rounding would
/// change it.
namespace rali::wire {

inline constexpr std::size_t kSeparatorPathsMax = 64, kSeparatorNodesMax = 256;
inline constexpr std::size_t kSeparatorBiasesMax = 1024;
inline constexpr Eigen::Index kSeparatorUnknownsMax = 480;

/// Nine numbers, so that forwarding does not change the bytes.
template <class Archive, class Pose>
void layout_exact_pose(Archive& a, Pose& T) {
  for (int k = 0; k < 9; ++k) a.real(T.R(k / 3, k % 3));
  a.double3(T.p);
  if constexpr (Archive::kReads) {
    constexpr double kSlack = 1e-6;
    const geometry::Mat3 should_be_one = T.R.transpose() * T.R;
    if (!(should_be_one - geometry::Mat3::Identity()).isZero(kSlack) || !(T.R.determinant() > 0)) {
      a.fail_with("holds no rotation");
      T.R.setIdentity();
    }
  }
}

template <class Archive, class Matrix>
void layout_lower_triangle(Archive& a, Matrix& m) {
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      a.real(m(i, j));
      if constexpr (Archive::kReads) m(j, i) = m(i, j);
    }
  }
}

template <class Body, class Of>
void layout_separator_prior(Body& body, Of& separator) {
  body.section(1, [&](auto& a) {
    a.varint(separator.term);
    a.number(separator.until.ns);
    a.list(separator.paths, kSeparatorPathsMax, [](auto& b, auto& path) {
      layout_stream(b, path.stream);
      b.varint(path.node);
      layout_exact_pose(b, path.T_map_body);
      layout_lower_triangle(b, path.covariance);
      b.flag(path.holds_map);
    });
  });
  body.section(2, [&](auto& a) {
    a.list(separator.nodes, kSeparatorNodesMax, [](auto& b, auto& node) {
      layout_stream(b, node.stream);
      b.varint(node.node);
      b.flag(node.has_speed);
      layout_exact_pose(b, node.x.T_odom_body);
      b.double3(node.x.v_odom_mps);
      b.double3(node.x.gyro_bias_radps);
      b.double3(node.x.accel_bias_mps2);
    });
    a.list(separator.biases, kSeparatorBiasesMax, [](auto& b, auto& bias) {
      b.varint(bias.a.value);
      b.varint(bias.b.value);
      b.number(bias.antenna_a);
      b.number(bias.antenna_b);
      b.real(bias.bias_m);
      b.varint(bias.ranges);
      b.varint(bias.used);
      b.real(bias.squares_m2);
    });
    a.maybe(separator.tau_s, [](auto& b, auto& tau) { b.real(tau); });
  });
  body.section(3, [&](auto& a) {
    if constexpr (Body::kReads) {
      const Eigen::Index n = separator.unknowns();
      if (n > kSeparatorUnknownsMax) return a.fail_with("has too many unknowns");
      // Allocates no more than the bytes justify.
      const auto numbers = static_cast<std::size_t>(n * (n + 1) / 2 + n);
      if (a.remaining() != numbers * sizeof(double)) return a.fail_with("has another size");
      separator.H.setZero(n, n);
      separator.b.setZero(n);
    }
    layout_lower_triangle(a, separator.H);
    for (Eigen::Index k = 0; k < separator.b.size(); ++k) a.real(separator.b[k]);
  });
}

}  // namespace rali::wire
