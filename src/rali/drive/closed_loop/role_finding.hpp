#pragma once

#include "rali/base/finding.hpp"
#include "rali/fleet/roles/role_state.hpp"

namespace rali::drive {

/// What a change of role means, for people.
[[nodiscard]] Finding role_finding(const fleet::RoleAction& action, Time t);

}  // namespace rali::drive
