#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/drive/input/message_reader.hpp"
#include "rali/host/live_order.hpp"
#include "rali/net/ros_bus.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/wire/linktrack_serial.hpp"

namespace rali::host {

/// Settings of the live sensor intake.
struct IntakeSetup {
  drive::InputOptions input;  ///< input.ranges is set by the intake
  drive::RangeOptions ranges;
  LiveOrderSettings order;
  std::vector<std::string> fleet;  ///< names of all vehicles
};

/// State of one sensor.
struct SensorHealth {
  std::string name, topic;
  std::uint64_t messages = 0;
  std::optional<Time> t_last;  ///< arrival
  double rate_hz = 0.0;        ///< recent; 0: not known
};

/// Converts messages of live sensors to ordered events of a vehicle. The first seconds decide how
/// to read the rest, exactly as for a recording. No thread, clock or socket: the caller passes
/// messages with their arrival times.
class SensorIntake {
 public:
  explicit SensorIntake(IntakeSetup setup);
  ~SensorIntake();

  /// Topics to subscribe to, among those published now; each once. Nothing is chosen until the
  /// candidates have been the same for two seconds, so that a second candidate is noticed.
  [[nodiscard]] std::vector<net::RosTopic> choose(std::span<const net::RosTopic> published,
                                                  Time now);

  /// A message of a chosen topic. @param t_arrival on the clock of this machine
  void take(const net::RosTopic& topic, Time t_arrival, std::span<const std::byte> message);

  /// Bytes of the LinkTrack radio's serial port.
  void take_serial(Time t_arrival, std::span<const std::byte> bytes);

  /// Appends the events that are due.
  void take_events(Time now, std::vector<LiveEvent>& out);

  /// When take_events() returns an event without another message.
  [[nodiscard]] std::optional<Time> due() const { return order_.due(); }

  /// The input is understood: report() holds the decisions, events are available.
  [[nodiscard]] bool decided() const { return reader_ != nullptr; }

  [[nodiscard]] const drive::InputReport& report() const { return report_; }

  /// One sentence; empty: it waits for nothing.
  [[nodiscard]] const std::string& waits_for() const { return waits_for_; }

  [[nodiscard]] const LiveOrderTally& order_tally() const { return order_.tally(); }

  [[nodiscard]] std::vector<SensorHealth> health() const;

  [[nodiscard]] FindingList take_findings();

 private:
  class Judge;

  /// Messages of one topic.
  struct Watch {
    std::string name;
    std::uint64_t messages = 0;
    std::optional<Time> t_last;
    std::deque<Time> recent;
  };

  void watch(const std::string& name, const std::string& topic, Time t);
  void store(const drive::RecordedMessage& message);
  void decide();
  void read(const drive::RecordedMessage& message);

  IntakeSetup setup_;
  std::shared_ptr<drive::RangeOptions> ranges_;  ///< with the topics that were found
  std::vector<std::string> chosen_;
  std::string candidates_;
  std::optional<Time> t_candidates_;
  bool has_sensors_ = false;

  std::deque<drive::StoredMessage> first_;
  std::size_t first_bytes_ = 0, first_clouds_ = 0;
  drive::InputReport report_;
  std::unique_ptr<drive::MessageReader> reader_;
  std::size_t findings_reported_ = 0;

  LiveOrder order_;
  std::unique_ptr<Judge> judge_;
  std::vector<LiveEvent> events_;  ///< passed on while messages were read
  wire::LinktrackStream serial_;
  std::unique_ptr<drive::RadioStamps> serial_stamps_;
  std::map<std::string, Watch> watches_;  ///< by topic
  std::string waits_for_;
};

}  // namespace rali::host
