#include <algorithm>
#include <utility>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

void Node::on(const Persisted& event) {
  for (const FactKey& key : event.facts) store_.persisted(key);
  exchange_.set_free_bytes(event.free_bytes);
  roles_kept_ = std::max(roles_kept_, event.role);
  while (!waiting_roles_.empty() && waiting_roles_.front().first <= roles_kept_) {
    RoleSend& send = waiting_roles_.front().second;
    post(send.to, std::move(send.message));
    waiting_roles_.pop_front();
  }
  if (!disk_fails_ || event.failing_facts > 0) return;
  disk_fails_ = false;
  report("fleet.disk_works", Severity::kInfo, "its disk keeps facts again; all are written");
}

/// The facts stay in memory, and no inventory names them. An anchor must be able to store the facts
/// of all vehicles.
void Node::on(const PersistFailed& event) {
  if (std::exchange(disk_fails_, true)) return;
  report("fleet.disk_fails", Severity::kError,
         "its disk takes no more facts (" + event.why +
             "): they are kept in memory, and it is no candidate for anchor");
}

void Node::on(const ConfirmRole&) { give(RoleConfirm{}); }

}  // namespace rali::fleet
