#include "rali/drive/closed_loop/role_finding.hpp"

#include <string_view>

#include <fmt/format.h>

namespace rali::drive {
namespace {

std::string_view role_text(fleet::RoleActionKind kind) {
  switch (kind) {
    case fleet::RoleActionKind::kBecameAnchor:
      return "is the anchor";
    case fleet::RoleActionKind::kRenewedTerm:
      return "is still the anchor";
    case fleet::RoleActionKind::kStoppedAnchoring:
      return "makes no more tables";
    case fleet::RoleActionKind::kFollows:
      return "follows a new anchor";
    case fleet::RoleActionKind::kSealed:
      return "ends its round";
    case fleet::RoleActionKind::kOrphaned:
      return "receives no anchor and stops";
    case fleet::RoleActionKind::kRejoined:
      return "receives an anchor again";
    case fleet::RoleActionKind::kMayLeave:
      return "was the anchor and may move";
    case fleet::RoleActionKind::kNotInFleet:
      return "is not counted on any more";
    case fleet::RoleActionKind::kConflict:
      return "received a second anchor";
    case fleet::RoleActionKind::kRefused:
      return "could not be elected";
  }
  return "";
}

}  // namespace

Finding role_finding(const fleet::RoleAction& action, Time t) {
  Finding finding;
  finding.id = "fleet.role";
  finding.severity = Severity::kInfo;
  finding.t = t;
  finding.text = fmt::format("{} (term {})", role_text(action.kind), action.term);
  return finding;
}

}  // namespace rali::drive
