#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/config.hpp"
#include "rali/events.hpp"
#include "rali/vehicle.hpp"

namespace rali {

/// The events of one vehicle's recording in order of time: scans in the LiDAR's frame, inertial
/// samples in SI units, ranges of the recording's topics. Stamps are repaired, damaged data are
/// left out. Memory does not grow with the recording. `rali map` processes the same events.
class RecordingReader {
 public:
  /// Opens the recording and decides how to read it. Throws SettingsError (no such vehicle),
  /// InputError (nothing readable).
  /// @param vehicle empty: the only vehicle
  explicit RecordingReader(const FleetConfig& config, const std::string& vehicle = {});
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  /// The next event; the last one is EndOfData, then nothing. Throws InputError, MachineError.
  [[nodiscard]] std::optional<Event> next();

  /// What a Vehicle needs for these events: calibration as given or read from the data, settings.
  [[nodiscard]] VehicleOptions vehicle_options() const;

  /// Fraction read, 0 to 1.
  [[nodiscard]] double progress() const;

  /// Findings about the data so far; complete after the last event.
  [[nodiscard]] std::vector<RunFinding> findings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali
