#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/assess/evaluation.hpp"

namespace rali::assess {

/// One `--limit`: a figure that must not be exceeded.
struct Limit {
  std::string vehicle;  ///< empty: all vehicles together
  std::string name;
  double max = 0.0;
  std::string text;  ///< as typed
};

/// `NAME=MAX` or `VEHICLE:NAME=MAX`. Errors (kUsage): unknown name (with the known ones), no
/// number, below zero.
[[nodiscard]] Result<Limit> parse_limit(const std::string& text);

/// The distance of rpe_<D>m_rmse_m [m]; nothing for other names.
[[nodiscard]] std::optional<double> rpe_distance_of(const std::string& name);

/// Names of limits; rpe_10m_rmse_m stands for any distance.
[[nodiscard]] const std::vector<std::string>& limit_names();

/// One sentence per limit that is exceeded or could not be checked.
[[nodiscard]] std::vector<std::string> broken_limits(const std::vector<Limit>& limits,
                                                     const Evaluation& evaluation);

}  // namespace rali::assess
