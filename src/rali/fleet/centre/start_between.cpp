#include "rali/fleet/centre/start_between.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

namespace rali::fleet {

namespace {

/// Consecutive measured start poses, from the start of a chain.
struct Chain {
  GivenStart start;
  double heading_sigma_rad = 0.0;  ///< of its end, without that of its start
};

/// Extends a chain by one step: `start` from either of its ends, at the end of the chain.
std::optional<Chain> with(const Chain& chain, const GivenStart& start) {
  const bool forward = start.relative_to == chain.start.vehicle;
  if (!forward && start.vehicle != chain.start.vehicle) return std::nullopt;
  Chain out = chain;
  out.start.vehicle = forward ? start.vehicle : start.relative_to;
  const geometry::SE3& T = start.T_relative_vehicle;
  out.start.T_relative_vehicle = chain.start.T_relative_vehicle * (forward ? T : T.inverse());
  out.start.sigma_rad = std::hypot(chain.start.sigma_rad, start.sigma_rad);
  // If the first step is traversed backwards, the chain rotates as a whole.
  const bool first = chain.start.vehicle == chain.start.relative_to;
  if (forward || !first) out.heading_sigma_rad = std::hypot(out.heading_sigma_rad, start.sigma_rad);
  const double swing_m = T.p.norm() * (forward ? chain.heading_sigma_rad : out.heading_sigma_rad);
  out.start.sigma_m = std::hypot(chain.start.sigma_m, start.sigma_m, swing_m);
  return out;
}

}  // namespace

std::optional<GivenStart> start_between(std::span<const GivenStart> starts, VehicleId from,
                                        VehicleId vehicle) {
  Chain begin;
  begin.start.relative_to = begin.start.vehicle = from;
  begin.start.sigma_m = begin.start.sigma_rad = 0.0;
  std::vector<VehicleId> reached{from};
  std::deque<Chain> chains{begin};
  while (!chains.empty()) {
    const Chain chain = chains.front();
    chains.pop_front();
    for (const GivenStart& start : starts) {
      const std::optional<Chain> next = with(chain, start);
      if (!next) continue;
      const VehicleId end = next->start.vehicle;
      if (end == vehicle) return next->start;
      if (std::find(reached.begin(), reached.end(), end) != reached.end()) continue;
      reached.push_back(end);
      chains.push_back(*next);
    }
  }
  return std::nullopt;
}

}  // namespace rali::fleet
