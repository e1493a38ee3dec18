#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

/// What errno means, in the same words on every machine and in every locale.
[[nodiscard]] std::string system_error_text(int error_number);

/// Whose fault it is that an input cannot be opened: the machine's (memory, disk, open files) or
/// that of the name that was given.
[[nodiscard]] ErrorCode input_error_code(int error_number);

}  // namespace rali::io
