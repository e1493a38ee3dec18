#include "rali/fleet/centre/separator_history.hpp"

#include <algorithm>
#include <utility>

#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

namespace {

/// False if none of its paths ends at a keyframe: then it cannot be checked.
bool ends_where(std::span<const VehiclePath> paths, const SeparatorPrior& separator,
                const FleetEstimate& estimate, double max_m) {
  std::size_t reported = 0;
  for (const SeparatorPath& known : separator.paths) {
    const VehiclePath* path = path_of(paths, known.stream);
    if (path == nullptr) return false;
    const auto node = path->index_of(known.node);
    if (!node) return false;
    const auto& keyframe = path->nodes()[*node].step->keyframe;
    if (!keyframe) continue;
    const auto pose = estimate.keyframes.find({path->vehicle(), *keyframe});
    if (pose == estimate.keyframes.end()) continue;
    const geometry::Vec6 moved = geometry::boxminus(pose->second.T_map_body, known.T_map_body);
    if (moved.cwiseAbs().maxCoeff() > max_m) return false;
    ++reported;
  }
  return reported > 0;
}

}  // namespace

void SeparatorHistory::push(SeparatorPrior separator) {
  if (max_ == 0) return;
  if (kept_.size() == max_) kept_.erase(kept_.begin());
  kept_.push_back(std::move(separator));
}

std::optional<SeparatorPrior> SeparatorHistory::take(std::span<const VehiclePath> paths,
                                                     std::span<const std::size_t> nodes,
                                                     std::size_t steps, std::vector<Time>& ends) {
  for (std::size_t step = 1; !kept_.empty(); ++step) {
    SeparatorPrior separator = std::move(kept_.back());
    kept_.pop_back();
    const std::vector<std::size_t> begins = begins_of(paths, &separator);
    const bool before =
        std::equal(begins.begin(), begins.end(), nodes.begin(), nodes.end(),
                   [](std::size_t begin, std::size_t node) { return begin <= node; });
    if (before && step >= steps) return separator;
    ends.insert(ends.begin(), separator.until);
  }
  return std::nullopt;
}

std::vector<std::size_t> SeparatorHistory::begins(std::span<const VehiclePath> paths,
                                                  std::size_t rounds) const {
  const std::size_t back = std::min(rounds, kept_.size());
  if (back == 0) return {};
  return begins_of(paths, &kept_[kept_.size() - back]);
}

void SeparatorHistory::keep_true(std::span<const VehiclePath> paths, const FleetEstimate& estimate,
                                 Time t, double max_m) {
  std::erase_if(kept_, [&](const SeparatorPrior& separator) {
    return separator.until >= t || separator.paths.size() != paths.size() ||
           !ends_where(paths, separator, estimate, max_m);
  });
}

}  // namespace rali::fleet
