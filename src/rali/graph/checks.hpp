#pragma once

#include "rali/graph/window.hpp"

namespace rali::graph {

// What the graph asks of its input (RALI_ASSERT where it is not so).

[[nodiscard]] bool finite(const geometry::SE3& T);
[[nodiscard]] bool finite(const KeyframeState& x);

/// A sigma or duration: a number above zero.
[[nodiscard]] bool positive(double sigma);

/// Numbers are numbers, and nodes and globals are in the window. Whether the range is new is not
/// asked here.
void check(const Window& window, const RangeFactor& f);
void check(const Window& window, const StandstillFactor& f);

/// Checked, and with the roots of their information.
[[nodiscard]] InertialTerm with_root(const Window& window, const InertialFactor& f);
[[nodiscard]] RelativeTerm with_root(const Window& window, const RelativePoseFactor& f);
[[nodiscard]] PriorTerm with_root(const Window& window, const PriorFactor& f);

/// Puts a landmark, bias or tau in its place.
void insert_global(Window& window, GlobalId id, const geometry::Vec3& mean,
                   const geometry::Mat3& information);
void insert_landmark(Window& window, int number, const geometry::Vec3& p_odom_m,
                     const geometry::Mat3& covariance);
/// A bias or tau.
void insert_scalar(Window& window, GlobalId id, double mean, double sigma);

}  // namespace rali::graph
