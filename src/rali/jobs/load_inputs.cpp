#include "rali/jobs/load_inputs.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "rali/jobs/load_states.hpp"

namespace rali::jobs {

bool is_yaml(const std::string& input) {
  const std::string extension = std::filesystem::path(input).extension().string();
  return extension == ".yaml" || extension == ".yml";
}

Result<MapInputs> load_inputs(const std::vector<std::string>& inputs,
                              const config::Overrides& overrides) {
  if (std::any_of(inputs.begin(), inputs.end(), drive::is_state_folder)) {
    return load_states(inputs, overrides);
  }
  const auto file = std::find_if(inputs.begin(), inputs.end(), is_yaml);
  if (file != inputs.end() && inputs.size() > 1) {
    return fail(ErrorCode::kUsage, *file, "a fleet.yaml is the only input",
                "Name the other recordings in it.");
  }
  Result<config::FleetConfig> fleet = file == inputs.end()
                                          ? config::fleet_of_recordings(inputs, overrides)
                                          : config::load_fleet(*file, overrides);
  if (!fleet) return tl::make_unexpected(fleet.error());
  return MapInputs{std::move(*fleet), nullptr};
}

Status check_format(const std::string& format, const std::string& where) {
  if (format == "pcd" || format == "ply" || format == "las") return {};
  return fail(ErrorCode::kUsage, where, fmt::format("'{}' is no format", format.substr(0, 60)),
              "Known here: pcd, ply, las.");
}

}  // namespace rali::jobs
