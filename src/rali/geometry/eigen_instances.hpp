#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "rali/geometry/types.hpp"

/// The decompositions of Eigen that many files use, compiled once in eigen_instances.cpp: each
/// costs 2 to 9 s in every file that compiles it anew. The modules' precompiled headers include
/// this header, so no file needs to. A build without them gives the same results. They take
/// matrices: what is given an expression, as in SelfAdjointEigenSolver<Mat3>(A * B), is compiled
/// anew there.

#ifndef RALI_EIGEN_INSTANCE
#define RALI_EIGEN_INSTANCE extern template
#endif

namespace Eigen {

#define RALI_EIGEN_SYMMETRIC(M)                                                         \
  RALI_EIGEN_INSTANCE SelfAdjointEigenSolver<M>& SelfAdjointEigenSolver<M>::compute<M>( \
      const EigenBase<M>&, int);
RALI_EIGEN_SYMMETRIC(Matrix2d)
RALI_EIGEN_SYMMETRIC(Matrix3d)
RALI_EIGEN_SYMMETRIC(rali::geometry::Mat6)
RALI_EIGEN_SYMMETRIC(MatrixXd)
#undef RALI_EIGEN_SYMMETRIC

RALI_EIGEN_INSTANCE class GeneralizedSelfAdjointEigenSolver<Matrix2d>;
RALI_EIGEN_INSTANCE class GeneralizedSelfAdjointEigenSolver<Matrix3d>;
RALI_EIGEN_INSTANCE class GeneralizedSelfAdjointEigenSolver<rali::geometry::Mat6>;

RALI_EIGEN_INSTANCE class PartialPivLU<rali::geometry::Mat6>;  // inverse(), too
RALI_EIGEN_INSTANCE class JacobiSVD<Matrix3d>;

}  // namespace Eigen
