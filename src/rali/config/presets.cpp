#include "rali/config/presets.hpp"

#include <array>

namespace rali::config {
namespace {

struct Preset {
  std::string_view name;
  std::string_view yaml;
};

// A preset lists only the differences from the defaults of the settings structs.
constexpr std::array kPresets{
    Preset{"robust", R"(
odometry:
  preset: robust
)"},
    Preset{"paper", R"(
odometry:
  preset: paper
  paper: {keyframe_overlap: 0.96}
fleet:
  init:
    bias_sigma_m: 0
    freeze: true
    scan2map: {weight: fixed}
    drift: {tilt_deg: 5}
    search: {huber: 1.345}
    commit: {rule: at_size, min_keyframes: 10}
  loops: {veto: false}
  solve: rounds
  separator_prior: {reopen: any, kept: 0}
  joint:
    bias: false
    line_of_sight: false
    common_error_sd: 0
    iterations: 10
    iterations_easy: 3
    graph: {guard: huber}
)"},
};

// Limits for walking and running people and for drones of every kind. A person turns and sidesteps,
// a drone flies sideways; neither keeps a height above ground. A hovering drone is not at
// standstill.
constexpr std::array kCarriers{
    Preset{"handheld", R"(
odometry:
  robust:
    constraints:
      non_holonomic: false
      ground: false
      speed_usual_mps: 1.5
      speed_max_mps: 12
      accel_max_mps2: 15
)"},
    Preset{"drone", R"(
odometry:
  robust:
    constraints:
      standstill: false
      non_holonomic: false
      ground: false
      speed_usual_mps: 5
      speed_max_mps: 60
      accel_max_mps2: 30
)"},
};

}  // namespace

bool is_preset(const std::string& name) { return !preset_yaml(name).empty(); }

std::string preset_names_text() {
  std::string text;
  for (const Preset& preset : kPresets) {
    text += (text.empty() ? "" : ", ") + std::string(preset.name);
  }
  return text;
}

std::string_view preset_yaml(const std::string& name) {
  for (const Preset& preset : kPresets) {
    if (preset.name == name) return preset.yaml;
  }
  return {};
}

std::string_view carrier_yaml(const std::string& name) {
  for (const Preset& carrier : kCarriers) {
    if (carrier.name == name) return carrier.yaml;
  }
  return {};
}

}  // namespace rali::config
