#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/finding_of.hpp"
#include "rali/host/bounded_queue.hpp"
#include "rali/host/duration_stats.hpp"
#include "rali/host/fleet_state.hpp"
#include "rali/host/host_clock.hpp"
#include "rali/host/job_worker.hpp"
#include "rali/host/live_host.hpp"
#include "rali/host/view_outputs.hpp"

/// Implementation of LiveHost: each file live_host_*.cpp holds the work of one thread.
namespace rali::host {

inline constexpr Duration kDiskWait = Duration::from_ns(100'000'000);

inline std::span<const std::byte> as_message(const std::vector<std::uint8_t>& bytes) {
  return std::as_bytes(std::span(bytes));
}

inline std::span<const std::uint8_t> as_octets_of(const wire::Bytes& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

/// A raw message for the recording.
struct Recorded {
  net::RosTopic topic;
  Time t;
  std::vector<std::uint8_t> cdr;
};

inline constexpr std::size_t kNewsMax = 50'000, kOutboxMax = 1000, kDiskMax = 100'000;
inline constexpr std::size_t kRecordMax = 4000;

class LiveHost::Impl {
 public:
  Impl(LiveHostSetup setup, const LiveHostParts& parts, Executor& executor)
      : setup_(std::move(setup)),
        parts_(parts),
        vehicle_(setup_.fleet.agent.names[setup_.fleet.agent.self.value]),
        sensors_(setup_.sensors, executor),
        fleet_(std::move(setup_.fleet), host_now()) {
    if (parts_.view != nullptr) view_ = std::make_unique<ViewOutputs>(*parts_.view, vehicle_);
  }

  LiveHostEnd run(HostListener& listener, const std::atomic<bool>& stop);

 private:
  // The thread of sensors and odometry.
  [[nodiscard]] Status advertise();
  void take_goal_status(const net::RosMessage& message, std::vector<ToAgent>& news);
  void sensor_loop(const std::atomic<bool>& stop);
  void look_for_topics(HostTime now);
  void publish(const RosOut& message);
  void send_news(std::vector<ToAgent>& news);
  void keep_poses();
  void drain_outbox();

  // Threads of the disk, the recording, the poses and the serial port.
  void disk_loop(const std::atomic<bool>& end);
  void record_loop(const std::atomic<bool>& end);
  void poses_loop(const std::atomic<bool>& end);
  void serial_loop(const std::atomic<bool>& end);

  // The caller's thread.
  void fleet_step(HostListener& listener);
  void hand_out(HostListener& listener);
  void take_jobs(HostTime now);
  void each_second(HostTime now, HostListener& listener);
  [[nodiscard]] HostFacts facts(HostTime now);
  void note(Finding finding, HostListener& listener);

  LiveHostSetup setup_;
  LiveHostParts parts_;
  std::string vehicle_;
  SensorSide sensors_;
  FleetSide fleet_;
  std::unique_ptr<ViewOutputs> view_;

  std::array<int, kRosTopics> publications_{};
  std::map<int, net::RosTopic> subscriptions_;
  int goal_status_ = -1;  ///< subscription
  std::optional<Time> next_topics_, next_sensor_news_;

  BoundedQueue<ToAgent> to_agent_{kNewsMax};
  BoundedQueue<ToSensors> to_sensors_{kOutboxMax};
  BoundedQueue<RosOut> outbox_{kOutboxMax}, to_view_{kOutboxMax};
  BoundedQueue<fleet::NodeOutput> to_disk_{kDiskMax};
  BoundedQueue<fleet::NodeEvent> from_disk_{kDiskMax};
  BoundedQueue<std::vector<std::byte>> seen_to_disk_{4};  ///< the newest counts
  BoundedQueue<Finding> findings_{kOutboxMax};
  BoundedQueue<Recorded> to_record_{kRecordMax};
  BoundedQueue<io::StampedPose> to_poses_{kRecordMax};
  BoundedQueue<net::SerialBytes> from_serial_{kOutboxMax};
  std::atomic<int> viewers_{0};
  std::atomic<bool> record_failed_{false};
  Status poses_status_;
  std::atomic<std::uint64_t> disk_free_{0}, disk_waiting_{0};

  // One worker each, so that neither goals nor the picture wait for an estimate.
  JobWorker estimates_{std::make_unique<SerialExecutor>()};
  JobWorker explorations_{std::make_unique<SerialExecutor>()};
  JobWorker pictures_{std::make_unique<SerialExecutor>()};
  FleetSideOutputs out_;
  DurationStats steps_;
  std::optional<Time> next_tick_, next_second_, t_rates_;
  std::map<VehicleId, std::uint64_t> bytes_before_;
  std::uint64_t refused_reported_ = 0;
  LiveState last_state_;
};

}  // namespace rali::host
