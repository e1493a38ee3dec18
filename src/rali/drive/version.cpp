#include "rali/drive/version.hpp"

namespace rali::drive {

std::string_view version() { return RALI_VERSION_TEXT; }

}  // namespace rali::drive
