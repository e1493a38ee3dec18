#pragma once

#include <span>
#include <string>
#include <vector>

#include "rali/eval/alignment.hpp"
#include "rali/eval/gauge.hpp"

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

/// Pairs of one vehicle and what it states.
struct StatedPairs {
  const eval::PairList* pairs = nullptr;
  const std::vector<geometry::Mat6>* covariances = nullptr;
  bool is_reference = false;
};

/// The gauge of vehicles that share a frame: the first judged pose of the reference vehicle. An
/// estimate that lies in the truth's own frame has none.
/// @param vehicles  if the reference vehicle is not among them, who states least stands in
[[nodiscard]] eval::Gauge frame_gauge(std::span<const StatedPairs> vehicles, eval::Alignment asked);

}  // namespace rali::assess
