// Settings files: any bytes either load or give one sentence; loaded values dump to the same
// values.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rali/base/assert.hpp"
#include "rali/config/load_fleet.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = rali::config::parse_fleet(text, "fleet.yaml", "", {});
  if (!config) {
    RALI_ASSERT(!config.error().message().empty());
    RALI_ASSERT(!config.error().where.empty());
    return 0;
  }
  const std::string dumped = rali::config::dump_fleet(*config, "");
  const auto again = rali::config::parse_fleet(dumped, "settings.yaml", "", {});
  RALI_ASSERT(again.has_value());
  RALI_ASSERT(rali::config::hash_fleet(*again) == rali::config::hash_fleet(*config));
  return 0;
}
