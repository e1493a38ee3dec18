#pragma once

#include "rali/base/settings.hpp"

namespace rali::fleet {

/// Settings of the exchange of facts (algorithms_fleet 11.2, middleware 4.2).
struct ExchangeSettings {
  double inventory_s = 5.0;
  double received_s = 3.0;
  double request_s = 0.5;
  double window_bytes = 65536.0;
  double patience_first_s = 2.0;
  double patience_min_s = 0.3;
  double patience_max_s = 10.0;
  double rate_first_Bps = 60000.0;
  double rate_min_Bps = 2000.0;
  double rate_max_Bps = 500000.0;
  double goodput_fraction = 0.7;

  template <class V>
  void visit(V& v) {
    v("inventory_s", inventory_s, 0.1, 600.0, "time between inventories of a vehicle");
    v("link_timeout_s", received_s, 0.1, 600.0, "a link is down after so long without a message");
    v("request_s", request_s, 0.0, 60.0, "least time between requests to one vehicle");
    v("window_bytes", window_bytes, 1500.0, 1e9, "bytes asked for and not yet come, per link");
    v("patience_first_s", patience_first_s, 0.01, 60.0,
      "wait for an answer before a link's delay is known");
    v("patience_min_s", patience_min_s, 0.01, 60.0, "shortest wait for an answer");
    v("patience_max_s", patience_max_s, 0.01, 600.0, "longest wait for an answer");
    v("rate_first_Bps", rate_first_Bps, 100.0, 1e9, "bytes per second to one vehicle, at first");
    v("rate_min_Bps", rate_min_Bps, 100.0, 1e9, "never less");
    v("rate_max_Bps", rate_max_Bps, 100.0, 1e9, "never more");
    v("goodput_fraction", goodput_fraction, 0.1, 1.0,
      "fraction of what arrived that is sent over a link that is full");
  }
};

}  // namespace rali::fleet
