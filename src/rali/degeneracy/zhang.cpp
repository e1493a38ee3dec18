#include "rali/degeneracy/zhang.hpp"

#include <Eigen/Eigenvalues>

namespace rali::degeneracy {

using geometry::Mat3;
using geometry::Mat6;

ZhangFactors::ZhangFactors(const Mat6& JtJ) {
  const Mat6 H = JtJ.allFinite() ? JtJ : Mat6(Mat6::Zero());
  const Eigen::SelfAdjointEigenSolver<Mat6> all(H);
  factors_ = all.eigenvalues().cwiseMax(0.0);  // rounding turns an exact zero into +-1e-16
  vectors_ = all.eigenvectors();
  const Mat3 shift = H.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Mat3> block(shift);
  translation_ = std::max(0.0, block.eigenvalues()[0]);
  direction_ = block.eigenvectors().col(0);
}

int ZhangFactors::degenerate(double threshold) const {
  return static_cast<int>((factors_.array() < threshold).count());
}

Mat6 ZhangFactors::remapping(double threshold) const {
  Mat6 P = Mat6::Zero();
  for (int k = 0; k < 6; ++k) {
    if (factors_[k] < threshold) continue;
    P += vectors_.col(k) * vectors_.col(k).transpose();
  }
  return P;
}

}  // namespace rali::degeneracy
