#pragma once

#include <string>
#include <vector>

#include "rali/assess/evaluation.hpp"
#include "rali/assess/limits.hpp"

namespace rali::assess {

/// Text of evaluation.json (schema 1). Nothing in it depends on the wall clock or threads.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation,
                                          const std::vector<Limit>& limits);

/// Text of errors/<v>.csv: `stamp_s,ape_m,rot_deg,ex,ey,ez,along_degenerate_m,nees`; the error (ex,
/// ey, ez) is estimate minus ground truth in the axes of the ground truth, nees of six dimensions.
[[nodiscard]] std::string errors_csv(const std::vector<PoseRow>& rows);

/// The table on the terminal, at most 80 columns for up to four vehicles.
[[nodiscard]] std::string evaluation_table(const Evaluation& evaluation);

/// evaluation.json and errors/<v>.csv in `folder`, each complete or absent; the status.json of a
/// run gets their SHA-256. Errors: kMachine.
[[nodiscard]] Status write_evaluation(const std::string& folder, const Evaluation& evaluation,
                                      const std::vector<Limit>& limits);

}  // namespace rali::assess
