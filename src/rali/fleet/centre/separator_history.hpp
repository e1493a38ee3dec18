#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/messages/separator_prior.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Separator priors of earlier rounds, the oldest first: a loop into one of the last rounds is
/// solved from the separator before it, not from all facts. No accepted loop spans a stored
/// separator that does not include it: closing a loop removes those.
class SeparatorHistory {
 public:
  /// @param maximum number that are kept; the oldest is dropped first
  explicit SeparatorHistory(std::size_t maximum) : max_(maximum) {}

  void push(SeparatorPrior separator);

  void clear() { kept_.clear(); }

  [[nodiscard]] std::size_t size() const { return kept_.size(); }

  /// The newest before all of these nodes, but at least `steps` back; it and those after it are
  /// removed. Nothing if there is none; then all are removed.
  /// @param nodes by path
  /// @param ends ascending; those of the separators after it are put in front
  [[nodiscard]] std::optional<SeparatorPrior> take(std::span<const VehiclePath> paths,
                                                   std::span<const std::size_t> nodes,
                                                   std::size_t steps, std::vector<Time>& ends);

  /// Start of the last `rounds` rounds, by path; nothing if there are none.
  [[nodiscard]] std::vector<std::size_t> begins(std::span<const VehiclePath> paths,
                                                std::size_t rounds) const;

  /// Keeps those before `t` whose path ends agree with the keyframes to `max_m` and rad: another
  /// anchor may have moved them since.
  void keep_true(std::span<const VehiclePath> paths, const FleetEstimate& estimate, Time t,
                 double max_m);

 private:
  std::size_t max_;
  std::vector<SeparatorPrior> kept_;
};

}  // namespace rali::fleet
