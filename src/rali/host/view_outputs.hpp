#pragma once

#include <array>
#include <string>

#include "rali/host/live_state.hpp"
#include "rali/host/ros_outputs.hpp"
#include "rali/view/view_server.hpp"

namespace rali::host {

/// The channels of a vehicle's live view.
class ViewOutputs {
 public:
  ViewOutputs(view::ViewServer& server, const std::string& vehicle);

  void publish(const RosOut& message);
  void publish_paths(Time t, const std::string& json);

  /// State, health and metrics.
  void publish(const LiveState& state);

 private:
  view::ViewServer& server_;
  std::array<int, kRosTopics> channels_{};
  int state_ = 0, paths_ = 0;
};

}  // namespace rali::host
