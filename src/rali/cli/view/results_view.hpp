#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/report/run_data.hpp"
#include "rali/view/view_server.hpp"
#include "rali/wire/byte_writer.hpp"

/// Finished results as messages of the live page (src/rali/view/README.md).
namespace rali::cli {

/// `/rali/history`: at most 600 states from the first to the last pose.
[[nodiscard]] std::string results_history(const report::RunData& run);

/// `/rali/state`: the last of them.
[[nodiscard]] std::string results_state(const report::RunData& run);

/// `/rali/paths`: trajectories, at most 5000 points per vehicle.
[[nodiscard]] std::string results_paths(const report::RunData& run);

/// `/map_cloud`: a PointCloud2 of at most 1 000 000 points with the vehicle of each, and its age
/// where `seen_s` (first_seen_s()) is not empty.
[[nodiscard]] wire::Bytes results_cloud(const report::RunData& run,
                                        const std::vector<float>& seen_s);

/// Publishes all of them; later subscribers receive them, too.
void publish_results(const report::RunData& run, const std::vector<float>& seen_s,
                     view::ViewServer& server);

}  // namespace rali::cli
