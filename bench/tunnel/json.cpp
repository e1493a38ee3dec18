#include <cmath>

#include <nlohmann/json.hpp>

#include "table.hpp"

namespace rali::tunnel {

namespace {

using nlohmann::json;

/// JSON has neither NaN nor infinity.
json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json path_json(const PathScores& s) {
  return {{"axial_rmse_m", number(s.axial_rmse_m)},
          {"axial_max_m", number(s.axial_max_m)},
          {"lateral_rmse_m", number(s.lateral_rmse_m)},
          {"vertical_rmse_m", number(s.vertical_rmse_m)},
          {"ape_rmse_m", number(s.ape_rmse_m)},
          {"ape_max_m", number(s.ape_max_m)},
          {"axial_start_rmse_m", number(s.start_rmse_m)},
          {"axial_start_max_m", number(s.start_max_m)},
          {"nees_axial", number(s.nees_axial)},
          {"nees6", number(s.nees6)}};
}

}  // namespace

std::string json_of(const std::vector<Scores>& runs) {
  json out = json::array();
  for (const Scores& s : runs) {
    out.push_back({{"row", s.row},
                   {"scene", s.scene},
                   {"seed", s.seed},
                   {"ranges", s.ranges},
                   {"live", path_json(s.live)},
                   {"smoothed", path_json(s.smoothed)},
                   {"way_m", number(s.path_m)},
                   {"judged_s", number(s.judged_s)},
                   {"t_worst_s", number(s.t_worst_s)},
                   {"heard_share", number(s.received)},
                   {"nis", number(s.nis)},
                   {"blind_share", number(s.degenerate)},
                   {"used_share", number(s.used)},
                   {"bad_share", number(s.bad)},
                   {"bad_refused_share", number(s.bad_refused)},
                   {"good_kept_share", number(s.good_kept)},
                   {"loss_growth_m", number(s.loss_growth_m)},
                   {"loss_back_s", number(s.loss_back_s)},
                   {"cpu_ms", number(s.cpu_ms)},
                   {"cpu_p99_ms", number(s.cpu_p99_ms)},
                   {"cloud_mean_m", number(s.cloud_mean_m)},
                   {"cloud_sd_m", number(s.cloud_sd_m)},
                   {"cloud_beyond_share", number(s.cloud_beyond)},
                   {"poses", s.poses},
                   {"sweeps", s.scans},
                   {"diverged", s.diverged},
                   {"findings", s.findings}});
  }
  return out.dump(1) + "\n";
}

}  // namespace rali::tunnel
