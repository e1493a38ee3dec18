#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/graph/values.hpp"

namespace rali::fleet {

/// Key of the facts of one start of one vehicle, numbered from 0; also the key of its odom frame.
struct StreamKey {
  VehicleId vehicle;
  std::uint32_t epoch = 0;
  constexpr auto operator<=>(const StreamKey&) const = default;
};

/// Where a path continues: its last node of the finished rounds.
struct SeparatorPath {
  StreamKey stream;
  std::uint32_t node = 0;  ///< its number
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  bool holds_map = false;  ///< the map's origin and heading are this node's
};

/// A node that the prior constrains.
struct SeparatorNode {
  StreamKey stream;
  std::uint32_t node = 0;
  bool has_speed = false;  ///< velocity and biases are unknowns of the prior
  graph::KeyframeState x;  ///< linearised there
};

/// A pair of antennas whose bias the prior constrains.
struct SeparatorBias {
  VehicleId a, b;
  std::uint8_t antenna_a = 0, antenna_b = 0;
  double bias_m = 0.0;
  // Of its ranges in the prior, for the report.
  std::uint32_t ranges = 0, used = 0;
  double squares_m2 = 0.0;  ///< sum over the squared residuals of those used
};

/// Separator prior: information of all facts of the finished rounds on the nodes at their end, cost
/// + b.d + d.H d/2 (algorithms_fleet 8.5). With it those rounds need not be solved again. It never
/// becomes invalid with age: later measurements are still in the facts.
struct SeparatorPrior {
  std::uint64_t term = 0;            ///< of the anchor that made it
  Time until;                        ///< no node of the finished rounds is later
  std::vector<SeparatorPath> paths;  ///< of one group, ascending by stream
  // The unknowns, in this order.
  std::vector<SeparatorNode> nodes;
  std::vector<SeparatorBias> biases;
  std::optional<double> tau_s;
  Eigen::MatrixXd H;  ///< symmetric
  Eigen::VectorXd b;

  [[nodiscard]] Eigen::Index unknowns() const {
    Eigen::Index n = tau_s ? 1 : 0;
    for (const SeparatorNode& node : nodes)
      n += node.has_speed ? graph::kStateDim : graph::kPoseDim;
    return n + static_cast<Eigen::Index>(biases.size());
  }
};

}  // namespace rali::fleet
