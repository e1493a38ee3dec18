#pragma once

#include <cstdint>
#include <span>

#include "rali/base/result.hpp"
#include "rali/fleet/roles/role_state.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::drive {

/// The contents of a role slot.
struct RoleRecord {
  VehicleId self;
  std::uint32_t epoch = 0;
  fleet::DurableRole durable;
  bool operator==(const RoleRecord&) const = default;
};

[[nodiscard]] wire::Bytes encode_role(const RoleRecord& record);

/// Errors: kInput for bytes that no encoder made; kNoAnswer for a record of a newer program.
[[nodiscard]] Result<RoleRecord> decode_role(std::span<const std::byte> bytes);

}  // namespace rali::drive
