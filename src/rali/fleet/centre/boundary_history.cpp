#include "rali/fleet/centre/boundary_history.hpp"

#include <algorithm>
#include <utility>

#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

namespace {

/// False where none of its paths ends at a keyframe: then nobody can tell.
bool ends_where(std::span<const VehiclePath> paths, const RoundBoundary& boundary,
                const FleetEstimate& estimate, double most_m) {
  std::size_t told = 0;
  for (const BoundaryPath& known : boundary.paths) {
    const VehiclePath* path = path_of(paths, known.stream);
    if (path == nullptr) return false;
    const auto node = path->index_of(known.node);
    if (!node) return false;
    const auto& keyframe = path->nodes()[*node].step.keyframe;
    if (!keyframe) continue;
    const auto pose = estimate.keyframes.find({path->vehicle(), *keyframe});
    if (pose == estimate.keyframes.end()) continue;
    const geometry::Vec6 moved = geometry::boxminus(pose->second.T_map_body, known.T_map_body);
    if (moved.cwiseAbs().maxCoeff() > most_m) return false;
    ++told;
  }
  return told > 0;
}

}  // namespace

void BoundaryHistory::push(RoundBoundary boundary) {
  if (most_ == 0) return;
  if (kept_.size() == most_) kept_.erase(kept_.begin());
  kept_.push_back(std::move(boundary));
}

std::optional<RoundBoundary> BoundaryHistory::take(std::span<const VehiclePath> paths,
                                                   std::span<const std::size_t> nodes,
                                                   std::size_t steps, std::vector<Time>& ends) {
  for (std::size_t step = 1; !kept_.empty(); ++step) {
    RoundBoundary boundary = std::move(kept_.back());
    kept_.pop_back();
    const std::vector<std::size_t> begins = begins_of(paths, &boundary);
    const bool before =
        std::equal(begins.begin(), begins.end(), nodes.begin(), nodes.end(),
                   [](std::size_t begin, std::size_t node) { return begin <= node; });
    if (before && step >= steps) return boundary;
    ends.insert(ends.begin(), boundary.until);
  }
  return std::nullopt;
}

std::vector<std::size_t> BoundaryHistory::begins(std::span<const VehiclePath> paths,
                                                 std::size_t rounds) const {
  const std::size_t back = std::min(rounds, kept_.size());
  if (back == 0) return {};
  return begins_of(paths, &kept_[kept_.size() - back]);
}

void BoundaryHistory::keep_true(std::span<const VehiclePath> paths, const FleetEstimate& estimate,
                                Time t, double most_m) {
  std::erase_if(kept_, [&](const RoundBoundary& boundary) {
    return boundary.until >= t || boundary.paths.size() != paths.size() ||
           !ends_where(paths, boundary, estimate, most_m);
  });
}

}  // namespace rali::fleet
