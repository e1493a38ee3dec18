#pragma once

#include <string>
#include <vector>

#include "recording.hpp"
#include "study.hpp"

namespace rali::recognition {

struct Arguments {
  std::vector<sim::Scene> scenes = {sim::Scene::kCorridor, sim::Scene::kFloor,
                                    sim::Scene::kLoop,     sim::Scene::kYard,
                                    sim::Scene::kGarage,   sim::Scene::kTunnel};
  std::vector<std::uint64_t> seeds = {1};
  RecordOptions record;
  PieceOptions piece;
  StudyOptions study;
  places::PlacesSettings settings;
  std::string cache_dir;
  bool stages = false;  ///< instead of the study
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::recognition
