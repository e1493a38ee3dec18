#pragma once

#include <span>
#include <string>
#include <vector>

#include "rali/eval/alignment.hpp"
#include "rali/eval/gauge.hpp"

namespace rali::assess {

/// An alignment and its kind.
struct FrameFit {
  geometry::SE3 T_truth_est;
  eval::Alignment used = eval::Alignment::kSe3;
  std::string why;  ///< sentence, if it is not the requested kind
};

/// eval::align(), with a fallback where the positions do not constrain the rotation. On a straight
/// trajectory the roll about it is noise, so yaw alone is solved. At standstill the first poses are
/// aligned.
/// Errors (kNoAnswer): no pairs.
[[nodiscard]] Result<FrameFit> fit_frame(const eval::PairList& pairs, eval::Alignment asked);

/// Pairs of one vehicle and its covariances.
struct StatedPairs {
  const eval::PairList* pairs = nullptr;
  const std::vector<geometry::Mat6>* covariances = nullptr;
  bool is_reference = false;
};

/// The gauge of vehicles that share a frame: origin and heading of the first evaluated pose of the
/// reference vehicle, and the level of the first pose that states it best. An estimate in the
/// ground truth's own frame has none.
/// @param vehicles  without the reference vehicle, the one with the smallest covariance replaces it
[[nodiscard]] eval::Gauge frame_gauge(std::span<const StatedPairs> vehicles, eval::Alignment asked);

}  // namespace rali::assess
