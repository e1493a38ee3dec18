#pragma once

#include "rali/degeneracy/evidence.hpp"

namespace rali::degeneracy {

/// A plane in line with the vehicle, whose normal has a sigma of 0.01 rad.
inline PlaneEvidence plane(const geometry::Vec3& n, int points) {
  PlaneEvidence out;
  out.n_odom = n;
  out.points = points;
  out.weight = 1.0 / (4e-4 / points + 1.02e-4);  // s_r = 2 cm, Spl_cc = 2e-6 + (1 cm)^2
  out.normal_covariance = 1e-4 * (geometry::Mat3::Identity() - n * n.transpose());
  return out;
}

}  // namespace rali::degeneracy
