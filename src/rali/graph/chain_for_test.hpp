#pragma once

#include <gtest/gtest.h>

#include "rali/graph/pose_graph.hpp"

namespace rali::graph {

/// A keyframe prior with these sigmas of the pose; velocity and biases known to 1e-3.
inline PriorFactor pose_prior(Seq seq, const KeyframeState& mean, double sigma_rad,
                              const geometry::Vec3& sigma_m) {
  PriorFactor f;
  f.i = seq;
  f.mean = mean;
  StateVec sigma = StateVec::Constant(1e-3);
  sigma.head<3>().setConstant(sigma_rad);
  sigma.segment<3>(kPos) = sigma_m;
  f.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  return f;
}

/// Relative pose without rotation; sigma 0 means no information.
inline RelativePoseFactor relative(Seq i, Seq j, const geometry::Vec3& p_m,
                                   const geometry::Vec3& sigma_m) {
  RelativePoseFactor f;
  f.i = i;
  f.j = j;
  f.T_i_j.p = p_m;
  f.information.diagonal().head<3>().setConstant(1e12);
  for (int d = 0; d < 3; ++d) {
    f.information(3 + d, 3 + d) = sigma_m(d) > 0.0 ? 1.0 / (sigma_m(d) * sigma_m(d)) : 0.0;
  }
  return f;
}

/// Range from the body of keyframe seq at its time (seconds = seq) to a fixed point.
inline RangeFactor fixed_range(std::uint64_t id, Seq seq, const geometry::Vec3& p_odom_m,
                               double range_m, double sigma_m) {
  RangeFactor f;
  f.id = id;
  f.t = Time::from_s(seq);
  f.i = seq;
  f.p_fixed_odom_m = p_odom_m;
  f.range_m = range_m;
  f.sigma_m = sigma_m;
  return f;
}

/// Adds the next keyframe, number seq, at this position.
inline void add_keyframe_at(PoseGraph& graph, Seq seq, const geometry::Vec3& p_odom_m) {
  KeyframeState x;
  x.T_odom_body.p = p_odom_m;
  EXPECT_EQ(graph.add_state(x), seq);
}

}  // namespace rali::graph
