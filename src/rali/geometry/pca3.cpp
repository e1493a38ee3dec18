#include "rali/geometry/pca3.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace rali::geometry {

Pca3 pca3(const Mat3& S) {
  // The iterative solver: the closed form loses accuracy in the small eigenvalue of thin planes,
  // which decides whether a plane is accepted.
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.compute(S);
  Pca3 out;
  out.values = solver.eigenvalues().reverse();
  out.vectors.col(0) = solver.eigenvectors().col(2);
  out.vectors.col(1) = solver.eigenvectors().col(1);
  out.vectors.col(2) = out.vectors.col(0).cross(out.vectors.col(1));
  return out;
}

}  // namespace rali::geometry
