#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rali/net/ros_bus.hpp"

namespace rali::host {

/// A bus with the test at its other end: the test reads published messages and injects others.
class BusForTest final : public net::RosBus {
 public:
  Result<int> advertise(const net::RosTopic& topic) override {
    publications.push_back(topic);
    return static_cast<int>(publications.size()) - 1;
  }

  void publish(int publication, std::span<const std::uint8_t> cdr) override {
    sent[publications.at(static_cast<std::size_t>(publication)).name].emplace_back(cdr.begin(),
                                                                                   cdr.end());
  }

  Result<int> subscribe(const net::RosTopic& topic) override {
    subscriptions.push_back(topic);
    return static_cast<int>(subscriptions.size()) - 1;
  }

  std::vector<net::RosMessage> take(Duration /*timeout*/) override {
    return std::exchange(arrived, {});
  }

  [[nodiscard]] std::vector<net::RosTopic> published() const override { return {}; }

  [[nodiscard]] int readers(int publication) const override {
    return listened.contains(publications.at(static_cast<std::size_t>(publication)).name) ? 1 : 0;
  }

  /// A message arrives on a subscribed topic.
  void arrive(const std::string& topic, const std::vector<std::byte>& bytes) {
    for (std::size_t s = 0; s < subscriptions.size(); ++s) {
      if (subscriptions[s].name != topic) continue;
      const auto* raw = reinterpret_cast<const std::uint8_t*>(bytes.data());
      arrived.push_back({static_cast<int>(s), Time{}, {raw, raw + bytes.size()}});
    }
  }

  std::vector<net::RosTopic> publications, subscriptions;
  std::map<std::string, std::vector<std::vector<std::uint8_t>>> sent;
  std::map<std::string, int> listened;
  std::vector<net::RosMessage> arrived;
};

}  // namespace rali::host
