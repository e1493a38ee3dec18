#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::cli {

/// Default address for the commands of a live fleet.
inline constexpr const char* kViewAddress = "http://127.0.0.1:8765";

/// Sends a request to a vehicle's view; `body` not empty: a command. The token comes from `token`,
/// else from the address, else from the variable RALI_TOKEN. @return the body. Errors: kUsage
/// (address), kMachine (no answer), kInput (refused, with the vehicle's own sentence).
[[nodiscard]] Result<std::string> ask_vehicle(const std::string& url, const std::string& token,
                                              const std::string& target,
                                              const std::string& body = {});

}  // namespace rali::cli
