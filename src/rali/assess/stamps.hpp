#pragma once

#include <string>

#include "rali/eval/association.hpp"

namespace rali::assess {

/// The error (kInput) for two trajectories without common times: both spans and the likely
/// cause, e.g. nanoseconds for seconds, a clock that starts at boot, a time
/// zone, another day.
[[nodiscard]] Error no_common_time(const eval::PoseList& est, const std::string& est_file,
                                   const eval::PoseList& truth, const std::string& truth_file,
                                   const eval::AssociationOptions& options);

}  // namespace rali::assess
