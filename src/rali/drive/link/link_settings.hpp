#pragma once

#include "rali/base/settings.hpp"

namespace rali::drive {

/// A radio link from one vehicle to another, in one direction.
struct LinkSettings {
  double rate_Bps = 0.0;          ///< 0: no limit
  double queue_bytes = 400000.0;  ///< messages beyond this queue length are lost
  double delay_s = 0.0;
  double jitter_s = 0.0;     ///< more delay, uniform from 0; messages overtake each other
  double loss = 0.0;         ///< fraction of messages
  double duplication = 0.0;  ///< fraction of messages that arrive twice, each with its own delay
  double reordering = 0.0;   ///< fraction of messages delayed by reorder_s
  double reorder_s = 0.5;

  template <class V>
  void visit(V& v) {
    v("rate_Bps", rate_Bps, 0.0, 1e9, "bytes per second of a link, 0: no limit");
    v("queue_bytes", queue_bytes, 1500.0, 1e9, "what waits for the link at most; more is lost");
    v("delay_s", delay_s, 0.0, 60.0, "delay of each message");
    v("jitter_s", jitter_s, 0.0, 60.0, "further delay, uniform from 0 to this");
    v("loss", loss, 0.0, 1.0, "share of messages that are lost");
    v("duplication", duplication, 0.0, 1.0, "share of messages that come twice");
    v("reordering", reordering, 0.0, 1.0, "share of messages that are held back");
    v("reorder_s", reorder_s, 0.0, 60.0, "for how long they are held back");
  }
};

}  // namespace rali::drive
