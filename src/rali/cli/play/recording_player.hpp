#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/message_source.hpp"
#include "rali/net/ros_bus.hpp"
#include "rali/wire/message_kind.hpp"
#include "rali/wire/ros1_to_cdr.hpp"

namespace rali::cli {

struct PlayOptions {
  std::string vehicle;              ///< "v1": topics become /v1/...; empty: as recorded
  double rate = 1.0;                ///< playback speed relative to the recording
  bool restamp = false;             ///< shift stamps as if it were recorded now
  std::vector<std::string> topics;  ///< as recorded; empty: all of sensors and transforms
};

/// The player's clock.
struct PlayClock {
  std::function<Time()> now;
  std::function<bool(Time)> sleep_until;  ///< false: stop
};

struct PlayTally {
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t damaged = 0;  ///< not convertible to CDR
  Duration latest;            ///< the largest delay relative to the recorded times
  bool stopped = false;
};

/// Publishes the messages of a recording at their recorded times. CDR is published byte for byte;
/// ROS 1 is converted by the definitions in the file.
class RecordingPlayer {
 public:
  RecordingPlayer(io::MessageSource& source, net::RosBus& bus, PlayOptions options,
                  PlayClock clock);

  /// Advertises the topics that are known before the first message. Errors: kInput (none of them).
  [[nodiscard]] Status advertise();

  /// Whether at least one cloud topic and one inertial topic, if there are any, have a subscriber;
  /// without these, any topic.
  [[nodiscard]] bool is_received() const;

  /// @param on_progress called periodically with the fraction of the file and the tally
  [[nodiscard]] Result<PlayTally> play(
      const std::function<void(double, const PlayTally&)>& on_progress);

  /// Topic names as published.
  [[nodiscard]] std::vector<std::string> published() const;

  /// One sentence for each topic that is left out.
  [[nodiscard]] const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Outlet {
    std::string name, type;
    wire::MessageKind kind = wire::MessageKind::kOther;
    int publication = 0;
    std::optional<wire::Ros1ToCdr> convert;
  };

  [[nodiscard]] Outlet* outlet_of(std::size_t topic);
  [[nodiscard]] std::optional<Outlet> open(const io::Topic& topic);
  [[nodiscard]] std::string name_of(const std::string& topic) const;
  [[nodiscard]] Time due(Time t_record);
  [[nodiscard]] std::uint64_t send(const Outlet& outlet, const io::RawMessage& message);

  io::MessageSource& source_;
  net::RosBus& bus_;
  PlayOptions options_;
  PlayClock clock_;
  std::map<std::size_t, std::optional<Outlet>> outlets_;  ///< by topic; empty: left out
  std::vector<std::string> left_out_;
  std::optional<Time> t_record_0_, t_record_last_;
  Time t_play_0_;
};

}  // namespace rali::cli
