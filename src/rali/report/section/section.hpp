#pragma once

#include <string>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// One part of the page.
struct Section {
  std::string id, title, html;
};

/// Each says in one line when it has nothing to show.
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

/// Runs side by side.
[[nodiscard]] std::vector<Section> comparison_sections(const std::vector<RunData>& runs);

/// The way as [begin of run, end of run] of all vehicles, for plots that share their time axis.
[[nodiscard]] double last_time_s(const RunData& run);

/// Position at a time, between the poses beside it; nothing outside the way.
[[nodiscard]] const WayPoint* pose_near(const std::vector<WayPoint>& way, double t_s);

/// "v1", "v1 and v2", "v1, v2 and v3"; escaped for HTML.
[[nodiscard]] std::string names_text(const std::vector<std::string>& names);

/// The first scalar of evaluation.json whose path is `key`.
[[nodiscard]] Number measured(const RunData& run, std::string_view key);

}  // namespace rali::report
