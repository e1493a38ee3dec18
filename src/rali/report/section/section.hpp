#pragma once

#include <string>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// One part of the page.
struct Section {
  std::string id, title, html;
};

/// A section without content states that in one line.
[[nodiscard]] Section verdict_section(const RunData& run);
[[nodiscard]] Section map_section(const RunData& run);
[[nodiscard]] Section view3d_section(const RunData& run);
[[nodiscard]] Section vehicles_section(const RunData& run);
[[nodiscard]] Section ranges_section(const RunData& run);
[[nodiscard]] Section fleet_section(const RunData& run);
[[nodiscard]] Section truth_section(const RunData& run);
[[nodiscard]] Section input_section(const RunData& run);
[[nodiscard]] Section speed_section(const RunData& run);
[[nodiscard]] Section settings_section(const RunData& run);

/// Several runs compared.
[[nodiscard]] std::vector<Section> comparison_sections(const std::vector<RunData>& runs);

/// Last time of all trajectories and degeneracy rows [s], for plots that share their time axis.
[[nodiscard]] double last_time_s(const RunData& run);

/// The pose nearest in time; null for an empty path.
[[nodiscard]] const PathPoint* pose_near(const std::vector<PathPoint>& path, double t_s);

/// "v1", "v1 and v2", "v1, v2 and v3"; escaped for HTML.
[[nodiscard]] std::string names_text(const std::vector<std::string>& names);

/// The first scalar of evaluation.json whose path is `key`.
[[nodiscard]] Number measured(const RunData& run, std::string_view key);

}  // namespace rali::report
