#pragma once

#include "rali/config/field.hpp"
#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {

/// The keys of scene.yaml that hold for this kind of place. They point into `setup`.
[[nodiscard]] config::FieldList scene_fields(SceneSetup& setup, const std::string& folder);

}  // namespace rali::scenario
