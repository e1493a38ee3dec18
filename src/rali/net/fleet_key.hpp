#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::net {

/// The secret that all vehicles of a fleet share.
struct FleetKey {
  std::array<std::uint8_t, 32> bytes{};
};

/// 64 hexadecimal digits, with or without blanks around. Errors: kInput (`where` names the source).
[[nodiscard]] Result<FleetKey> parse_fleet_key(std::string_view text, const std::string& where);

/// Reads a key file. Errors: kMachine (not readable), kInput (no key in it, or users other than its
/// owner may read or write it).
[[nodiscard]] Result<FleetKey> load_fleet_key(const std::string& path);

/// Makes a random key and writes it to a new file that only its owner may read.
/// Errors: kMachine (the file already exists, disk).
[[nodiscard]] Result<FleetKey> create_fleet_key(const std::string& path);

}  // namespace rali::net
