// Scene files: any bytes either load or give one sentence; a loaded scene dumps to the same scene,
// and small floor plans are built.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "rali/base/assert.hpp"
#include "rali/scenario/scene/scene_setup.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace scenario = rali::scenario;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto setup = scenario::parse_scene(text, "scene.yaml", "");
  if (!setup) {
    RALI_ASSERT(!setup.error().message().empty());
    RALI_ASSERT(!setup.error().where.empty());
    return 0;
  }
  const std::string dumped = scenario::dump_scene(*setup, "");
  const auto again = scenario::parse_scene(dumped, "scene.yaml", "");
  RALI_ASSERT(again.has_value());
  RALI_ASSERT(scenario::dump_scene(*again, "") == dumped);
  // Building large plans may take long; meshes would be read from the disk.
  const bool small = setup->place == scenario::PlaceKind::kFloorPlan &&
                     setup->floor_plan.areas.size() <= 8 && size < 2000;
  if (!small) return 0;
  const auto plan = scenario::floor_plan_of(setup->floor_plan);
  if (plan) (void)rali::sim::floor_plan_mesh(*plan);
  return 0;
}
