#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rali/io/files/range_csv.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::drive {

/// The clock for the stamps of a topic's ranges: the message's header, else the radio's own clock
/// (auto); the radio's clock; the recorder's.
enum class RangeStamp { kAuto, kDevice, kRecord };

/// A CSV of ranges.
struct RangeFile {
  std::string path;
  VehicleId clock;  ///< the vehicle whose clock has stamped it
};

/// A topic of the recordings that carries ranges.
struct RangeTopic {
  std::string topic;
  std::map<std::int64_t, io::RadioEnd> ids;  ///< radio number to antenna
};

/// Recorded serial output of a LinkTrack radio.
struct SerialLog {
  std::string path;
  VehicleId vehicle;                         ///< that carried the radio
  std::map<std::int64_t, io::RadioEnd> ids;  ///< as of a topic
};

/// Sources and properties of the ranges of a job; the same for all vehicles.
struct RangeOptions {
  std::vector<RangeFile> files;
  std::vector<RangeTopic> topics;
  std::vector<SerialLog> serial_logs;
  io::RadioNames names;               ///< "v1", "v1/uwb"
  std::vector<std::size_t> antennas;  ///< number of antennas of each vehicle
  RangeStamp stamp = RangeStamp::kAuto;
  std::optional<double> latency_s;  ///< age of a range at its stamp, subtracted; empty: not known
  std::array<double, 2> limits_m = {0.2, 200.0};
  ranging::ArrivalClockSettings arrival;
  ranging::ExchangeSettings exchange;

  [[nodiscard]] Duration latency() const { return Duration::from_s(latency_s.value_or(0.0)); }

  /// The source that reads this topic, null if there is none.
  [[nodiscard]] const RangeTopic* topic_of(std::string_view topic) const {
    for (const RangeTopic& t : topics) {
      if (t.topic == topic) return &t;
    }
    return nullptr;
  }
};

/// Ends that belong to no vehicle keep a number of their own, so that ranges.csv can name them:
/// radios of frames by their number, names of files by their order.
inline constexpr std::uint16_t kUnknownRadios = 0x8000, kUnknownNames = 0xc000;
inline constexpr VehicleId kNobody{0xffff};  ///< if the number is too large

[[nodiscard]] inline VehicleId unknown_radio(std::uint64_t number) {
  constexpr std::uint64_t kRoom = kUnknownNames - kUnknownRadios;
  if (number >= kRoom) return kNobody;
  return {static_cast<std::uint16_t>(kUnknownRadios + number)};
}

[[nodiscard]] inline VehicleId unknown_name(std::uint64_t index) {
  constexpr std::uint64_t kRoom = 0xffff - kUnknownNames;
  if (index >= kRoom) return kNobody;
  return {static_cast<std::uint16_t>(kUnknownNames + index)};
}

}  // namespace rali::drive
