#pragma once

#include <string>
#include <string_view>

namespace rali::config {

/// For the name of an extrinsic in other systems (T_lidar_body, extrinsicRot, extrinsic_T, ...):
/// which key to use here and whether to invert. Empty for any other name.
[[nodiscard]] std::string foreign_name_remedy(std::string_view key);

}  // namespace rali::config
