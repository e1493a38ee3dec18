#pragma once

#include <string>

namespace rali::io {

/// What errno means, in the same words on every machine and in every locale.
[[nodiscard]] std::string system_error_text(int error_number);

}  // namespace rali::io
