#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/messages/boundary.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Boundaries of earlier rounds, the oldest first: a loop into one of the last rounds is solved on
/// the boundary before it, not on all facts. No loop that was closed lies over a boundary that is
/// kept and does not know of it: closing it has taken those away.
class BoundaryHistory {
 public:
  /// @param most that are kept; the oldest is forgotten first
  explicit BoundaryHistory(std::size_t most) : most_(most) {}

  void push(RoundBoundary boundary);

  void clear() { kept_.clear(); }

  [[nodiscard]] std::size_t size() const { return kept_.size(); }

  /// The newest before all of these nodes, but at least `steps` back; it and those after it are not
  /// kept any longer. Nothing: none is, and none is kept any longer.
  /// @param nodes by path
  /// @param ends growing; those of the boundaries after it are put in front
  [[nodiscard]] std::optional<RoundBoundary> take(std::span<const VehiclePath> paths,
                                                  std::span<const std::size_t> nodes,
                                                  std::size_t steps, std::vector<Time>& ends);

  /// Where the last so many rounds begin, by path; nothing if there are none.
  [[nodiscard]] std::vector<std::size_t> begins(std::span<const VehiclePath> paths,
                                                std::size_t rounds) const;

  /// Keeps those before `t` whose paths end where the keyframes lie, to `most_m` and rad: another
  /// anchor may have moved them since.
  void keep_true(std::span<const VehiclePath> paths, const FleetEstimate& estimate, Time t,
                 double most_m);

 private:
  std::size_t most_;
  std::vector<RoundBoundary> kept_;
};

}  // namespace rali::fleet
