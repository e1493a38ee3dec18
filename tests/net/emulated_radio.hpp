#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <queue>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "rali/base/rng.hpp"

namespace rali::net {

/// One direction of a link between two vehicles.
struct LinkModel {
  double loss = 0.0;                  ///< probability per Ethernet frame, independent
  double delay_s = 0.0;               ///< one way
  double jitter_s = 0.0;              ///< more delay, uniform from 0 to this: frames overtake
  double bytes_per_s = 0.0;           ///< 0: no limit
  std::size_t queue_bytes = 400'000;  ///< before the bottleneck; excess is dropped
  bool cut = false;
};

/// Vehicles on one machine, each in its own network namespace with one Ethernet interface
/// (10.77.0.n), and between them a program that forwards frames with the configured losses. Needs
/// root and /dev/net/tun; no kernel module. ARP is never lost, otherwise tests would measure its
/// timers.
class EmulatedRadio {
 public:
  /// @return nothing if the machine does not allow it; `why_not` is then the reason
  [[nodiscard]] static std::unique_ptr<EmulatedRadio> create(std::size_t vehicles,
                                                             std::string& why_not);
  ~EmulatedRadio();
  EmulatedRadio(const EmulatedRadio&) = delete;
  EmulatedRadio& operator=(const EmulatedRadio&) = delete;

  [[nodiscard]] static std::string address(std::size_t vehicle) {
    return "10.77.0." + std::to_string(vehicle + 1);
  }

  /// File of the network namespace of a vehicle, as `nsenter --net=` takes it, while this lives.
  [[nodiscard]] std::string space(std::size_t vehicle) const;

  /// Moves the calling thread into the network of a vehicle. For children of a fork.
  [[nodiscard]] bool enter(std::size_t vehicle) const;

  /// Sets both directions of all links.
  void set_all(const LinkModel& model);
  void set(std::size_t from, std::size_t to, const LinkModel& model);

  /// Starts forwarding frames; call after all forks.
  void start();

  /// Frames sent into the link and delivered by it.
  struct Traffic {
    std::uint64_t frames_in = 0, frames_out = 0, bytes_out = 0;
  };

  [[nodiscard]] Traffic traffic(std::size_t from, std::size_t to) const;

 private:
  struct Port {
    int tap = -1, space = -1;
  };

  struct Link {
    LinkModel model;
    double free_s = 0.0;  ///< time at which the bottleneck has sent its queue
    Traffic traffic;
  };

  struct Frame {
    double due_s = 0.0;
    std::uint64_t order = 0;
    std::size_t from = 0, to = 0;
    std::vector<std::uint8_t> bytes;

    bool operator>(const Frame& other) const {
      return due_s != other.due_s ? due_s > other.due_s : order > other.order;
    }
  };

  explicit EmulatedRadio(std::size_t vehicles);
  [[nodiscard]] bool add_port(std::size_t vehicle, std::string& why_not);

  [[nodiscard]] Link& link(std::size_t from, std::size_t to) {
    return links_[from * ports_.size() + to];
  }

  void run(const std::stop_token& stop);
  void read_port(std::size_t from);
  void forward(std::size_t from, std::size_t to, const std::vector<std::uint8_t>& bytes);
  void deliver_due();

  std::vector<Port> ports_;
  mutable std::mutex mutex_;
  std::vector<Link> links_;
  std::priority_queue<Frame, std::vector<Frame>, std::greater<>> frames_;
  std::uint64_t order_ = 0;
  Rng rng_;
  std::jthread thread_;
};

}  // namespace rali::net
