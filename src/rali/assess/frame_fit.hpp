#pragma once

#include <string>

#include "rali/eval/alignment.hpp"

namespace rali::assess {

/// An alignment and which one it is.
struct FrameFit {
  geometry::SE3 T_truth_est;
  eval::Alignment used = eval::Alignment::kSe3;
  std::string why;  ///< sentence, if it is not the one asked for
};

/// eval::align(), with a way out where the positions leave the rotation open: on a straight way
/// the roll about it is noise, so yaw alone is solved; at rest the first poses are laid together.
/// Errors (kNoAnswer): no pairs.
[[nodiscard]] Result<FrameFit> fit_frame(const eval::PairList& pairs, eval::Alignment asked);

/// The pair from which the frame of the covariances is taken: one second after the first, so that
/// an estimator that levels itself with its first sweeps is not blamed for the very first one.
[[nodiscard]] std::size_t anchor_pair(const eval::PairList& pairs);

}  // namespace rali::assess
