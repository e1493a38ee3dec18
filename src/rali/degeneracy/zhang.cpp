#include "rali/degeneracy/zhang.hpp"

#include <Eigen/Eigenvalues>

namespace rali::degeneracy {

using geometry::Mat3;
using geometry::Mat6;

ZhangFactors::ZhangFactors(const Mat6& JtJ) {
  const Mat6 H = JtJ.allFinite() ? JtJ : Mat6(Mat6::Zero());
  const Eigen::SelfAdjointEigenSolver<Mat6> all(H, Eigen::EigenvaluesOnly);
  factors_ = all.eigenvalues().cwiseMax(0.0);  // rounding turns an exact zero into +-1e-16
  const Mat3 shift = H.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Mat3> block(shift);
  translation_ = std::max(0.0, block.eigenvalues()[0]);
  direction_ = block.eigenvectors().col(0);
}

int ZhangFactors::degenerate(double threshold) const {
  return static_cast<int>((factors_.array() < threshold).count());
}

}  // namespace rali::degeneracy
