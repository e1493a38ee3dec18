#include "rali/fleet/node/explore_job.hpp"

#include <algorithm>
#include <utility>

namespace rali::fleet {

void ExploreJob::run(Executor& /*executor*/, const std::atomic<bool>& cancel) {
  const StopFlag stop(cancel);
  for (const FactPtr& fact : std::exchange(facts_, {})) map_->add(fact);
  const std::uint64_t before = map_->grid().cells_written();
  const bool drawn = map_->draw(*in_.placed, stop);
  work_.cells_drawn = static_cast<std::size_t>(map_->grid().cells_written() - before);
  if (!drawn) return;
  in_.kind == JobKind::kNextAnchor ? end_round(stop) : look();
  ended_ = !stop.raised();
}

/// Each path search of each vehicle visits all cells at most once.
void ExploreJob::count_searches(std::size_t paths) {
  const map::CellMap* map = dispatcher_.map();
  if (map != nullptr) work_.cells_searched += paths * map->cells.size();
}

void ExploreJob::look() {
  const std::size_t n = in_.fleet.size();
  const auto self = std::find_if(in_.fleet.begin(), in_.fleet.end(),
                                 [this](const PeerState& w) { return w.vehicle == in_.self; });
  const auto anchor = self == in_.fleet.end()
                          ? std::nullopt
                          : std::optional(static_cast<std::size_t>(self - in_.fleet.begin()));
  result_.mapped = dispatcher_.look(*map_, in_.fleet, anchor, in_.now);
  count_searches(1 + 2 * n);
  if (result_.mapped) result_.goals = dispatcher_.goals(*map_);
}

/// No vehicle is sent: all keep standstill until there is an anchor again.
void ExploreJob::end_round(StopFlag stop) {
  const std::size_t n = in_.fleet.size();
  std::vector<PeerState> standing = in_.fleet;
  for (PeerState& w : standing) w.stands = true;
  result_.mapped = dispatcher_.look(*map_, standing, std::nullopt, in_.now);
  count_searches(1 + n);
  result_.progress =
      !in_.progress_since || map_->new_places_since(*in_.progress_since, place_m_) > 0;
  if (result_.mapped && !stop.raised()) {
    dispatcher_.note_who_stands(in_.fleet);
    if (result_.progress) {
      result_.next_anchors = dispatcher_.next_anchors(*map_, in_.fleet, in_.self);
      count_searches(2 * n * n);
    } else {
      result_.stops = dispatcher_.stops(*map_, in_.fleet, in_.self);
      count_searches(n * n);
    }
  }
  dispatcher_.new_round();
  result_.goals = dispatcher_.goals(*map_);
  if (in_.forget_points) map_->forget_drawn_points();
}

}  // namespace rali::fleet
