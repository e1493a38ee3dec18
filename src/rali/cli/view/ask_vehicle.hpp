#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::cli {

/// Where the commands of a live fleet look if no address is given.
inline constexpr const char* kViewAddress = "http://127.0.0.1:8765";

/// Asks a vehicle's view; `body` not empty: an order. The token is that of `token`, else of the
/// address, else of the variable RALI_TOKEN. @return the body. Errors: kUsage (address),
/// kMachine (no answer), kInput (refused, with the vehicle's own sentence).
[[nodiscard]] Result<std::string> ask_vehicle(const std::string& url, const std::string& token,
                                              const std::string& target,
                                              const std::string& body = {});

}  // namespace rali::cli
