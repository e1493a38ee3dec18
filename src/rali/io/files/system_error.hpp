#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

/// Text for errno, the same on every machine and in every locale.
[[nodiscard]] std::string system_error_text(int error_number);

/// Error class for an input that cannot be opened: the machine's fault (memory, disk, open files)
/// or that of the given name.
[[nodiscard]] ErrorCode input_error_code(int error_number);

}  // namespace rali::io
