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
/// samples in SI units, ranges of the recording's topics; stamps repaired, damage left out. Memory
/// does not grow with the recording. What leaves is what `rali map` processes.
class RecordingReader {
 public:
  /// Opens the recording and decides how to read it. Throws SettingsError (no such vehicle),
  /// InputError (nothing there that can be read).
  /// @param vehicle empty: the only one
  explicit RecordingReader(const FleetConfig& config, const std::string& vehicle = {});
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  /// The next event; last EndOfData, then nothing. Throws InputError, MachineError.
  [[nodiscard]] std::optional<Event> next();

  /// What a Vehicle needs for these events: calibration as given or found in the data, settings.
  [[nodiscard]] VehicleOptions vehicle_options() const;

  /// 0 to 1.
  [[nodiscard]] double progress() const;

  /// About the data, so far; complete after the last event.
  [[nodiscard]] std::vector<RunFinding> findings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali
