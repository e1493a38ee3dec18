#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/graph/values.hpp"

namespace rali::fleet {

/// The facts of one start of one vehicle, numbered from 0; also the name of its odom frame.
struct StreamKey {
  VehicleId vehicle;
  std::uint32_t epoch = 0;
  constexpr auto operator<=>(const StreamKey&) const = default;
};

/// Where one path goes on: its last node of the finished rounds.
struct BoundaryPath {
  StreamKey stream;
  std::uint32_t node = 0;  ///< its number
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  bool holds_map = false;  ///< the map's frame hangs on this node: it is exactly there
};

/// A node that the prior speaks of.
struct BoundaryNode {
  StreamKey stream;
  std::uint32_t node = 0;
  bool has_speed = false;  ///< velocity and biases are unknowns of the prior
  graph::KeyframeState x;  ///< linearised there
};

/// A pair of antennas whose bias the prior speaks of.
struct BoundaryBias {
  VehicleId a, b;
  std::uint8_t antenna_a = 0, antenna_b = 0;
  double bias_m = 0.0;
  // Of its ranges that are in the prior, for the report.
  std::uint32_t ranges = 0, used = 0;
  double squares_m2 = 0.0;  ///< sum over the squared residuals of those used
};

/// What all facts of the finished rounds say about the nodes at their end: cost + b.d + d.H d/2
/// (algorithms_fleet 8.5). Who has it need not solve for those rounds again. It stays true however
/// old it is: what came later is still in the facts.
struct RoundBoundary {
  std::uint64_t term = 0;           ///< of the anchor that made it
  Time until;                       ///< no node of the finished rounds is later
  std::vector<BoundaryPath> paths;  ///< of one group, ascending by stream
  // The unknowns, in this order.
  std::vector<BoundaryNode> nodes;
  std::vector<BoundaryBias> biases;
  std::optional<double> tau_s;
  Eigen::MatrixXd H;  ///< symmetric
  Eigen::VectorXd b;

  [[nodiscard]] Eigen::Index unknowns() const {
    Eigen::Index n = tau_s ? 1 : 0;
    for (const BoundaryNode& node : nodes) n += node.has_speed ? graph::kStateDim : graph::kPoseDim;
    return n + static_cast<Eigen::Index>(biases.size());
  }
};

}  // namespace rali::fleet
