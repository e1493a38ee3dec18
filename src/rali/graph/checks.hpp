#pragma once

#include "rali/graph/window.hpp"

namespace rali::graph {

// Checks of the graph's input (RALI_ASSERT if violated).

[[nodiscard]] bool finite(const geometry::SE3& T);
[[nodiscard]] bool finite(const KeyframeState& x);

/// A sigma or duration: finite and positive.
[[nodiscard]] bool positive(double sigma);

/// Checks that numbers are finite, and that nodes and globals are in the window. Whether the range
/// is new is not checked.
void check(const Window& window, const RangeFactor& f);
void check(const Window& window, const StandstillFactor& f);

/// Checks the factor and adds the root of its information.
[[nodiscard]] InertialTerm with_root(const Window& window, const InertialFactor& f);
[[nodiscard]] RelativeTerm with_root(const Window& window, const RelativePoseFactor& f);
[[nodiscard]] PriorTerm with_root(const Window& window, const PriorFactor& f);

/// Inserts a landmark, bias or tau in order.
void insert_global(Window& window, GlobalId id, const geometry::Vec3& mean,
                   const geometry::Mat3& information);
void insert_landmark(Window& window, int number, const geometry::Vec3& p_odom_m,
                     const geometry::Mat3& covariance);
/// A bias or tau.
void insert_scalar(Window& window, GlobalId id, double mean, double sigma);

}  // namespace rali::graph
