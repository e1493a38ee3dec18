#pragma once

#include "rali/base/finding.hpp"
#include "rali/fleet/roles/role_state.hpp"

namespace rali::drive {

/// Explains a change of role to the user.
[[nodiscard]] Finding role_finding(const fleet::RoleAction& action, Time t);

}  // namespace rali::drive
