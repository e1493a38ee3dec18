#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// Where a vehicle's events come from: a recording, a folder of scans, the generator.
class EventSource {
 public:
  virtual ~EventSource() = default;

  /// The next event in time order (late events are dropped and counted); empty at the end.
  [[nodiscard]] virtual Result<std::optional<vehicle::Event>> next() = 0;

  /// Fraction of the input that has been read, 0 to 1.
  [[nodiscard]] virtual double progress() const = 0;
};

}  // namespace rali::drive
