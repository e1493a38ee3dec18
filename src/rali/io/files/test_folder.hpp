#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "rali/base/test_folder.hpp"

namespace rali::io {

using rali::TestFolder;

/// Path in the folder of real recordings; empty where it is absent.
inline std::string real_data(std::string_view name) {
  const std::filesystem::path path = std::filesystem::path(RALI_DATA_DIR) / name;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

}  // namespace rali::io

/// Skips the test, with a message, if the real recordings are absent.
#define RALI_NEEDS_DATA(name)              \
  if (::rali::io::real_data(name).empty()) \
  GTEST_SKIP() << "REAL DATA ABSENT: " << RALI_DATA_DIR << "/" << (name) << " not tested"
