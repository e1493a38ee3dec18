#pragma once

#include "rali/config/field.hpp"
#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {

/// The keys of scene.yaml that are valid for this kind of world. They point into `setup`.
[[nodiscard]] config::FieldList scene_fields(SceneSetup& setup, const std::string& folder);

}  // namespace rali::scenario
