#pragma once

#include <string>
#include <vector>

#include "rali/base/time.hpp"

namespace rali {

enum class Severity { kInfo, kWarning, kError };

/// Something the user should know, returned as a value by modules that must not log.
struct Finding {
  std::string id;  ///< stable, e.g. "D08" of the doctor or "odometry.diverged"
  Severity severity = Severity::kWarning;
  Time t;               ///< data time, 0 if it concerns the whole recording
  Time t_end;           ///< end of the period that starts at t; 0: it concerns t alone
  std::string vehicle;  ///< empty if there is only one
  std::string topic;    ///< empty if no topic is concerned
  std::string text;     ///< one sentence: what was found, with its numbers and units
  std::string effect;   ///< what it does to the map; may be empty
  std::string remedy;   ///< what to do; may be empty
  double value = 0.0;   ///< the measured number
  double limit = 0.0;   ///< the number it was compared with
};

using FindingList = std::vector<Finding>;

}  // namespace rali
