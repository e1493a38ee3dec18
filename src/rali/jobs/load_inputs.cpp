#include "rali/jobs/load_inputs.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

namespace rali::jobs {
namespace {

bool is_yaml(const std::string& input) {
  const std::string extension = std::filesystem::path(input).extension().string();
  return extension == ".yaml" || extension == ".yml";
}

}  // namespace

Result<config::FleetConfig> load_inputs(const std::vector<std::string>& inputs,
                                        const config::Overrides& overrides) {
  const auto file = std::find_if(inputs.begin(), inputs.end(), is_yaml);
  if (file == inputs.end()) return config::fleet_of_recordings(inputs, overrides);
  if (inputs.size() > 1) {
    return fail(ErrorCode::kUsage, *file, "a fleet.yaml is the only input",
                "Name the other recordings in it.");
  }
  return config::load_fleet(*file, overrides);
}

Status check_format(const std::string& format, const std::string& where) {
  if (format == "pcd" || format == "ply" || format == "las") return {};
  return fail(ErrorCode::kUsage, where, fmt::format("'{}' is no format", format.substr(0, 60)),
              "Known here: pcd, ply, las.");
}

}  // namespace rali::jobs
