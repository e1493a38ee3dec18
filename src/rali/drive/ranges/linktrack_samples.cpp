#include "rali/drive/ranges/linktrack_samples.hpp"

namespace rali::drive {

void append_linktrack(const wire::LinktrackFrame& frame, Time t,
                      const std::map<std::int64_t, io::RadioEnd>& ids, VehicleId self,
                      std::vector<sensor::RangeSample>& out) {
  const auto own = ids.find(static_cast<std::int64_t>(frame.id));
  // The recording radio belongs to the owner of the recordings, unless the list says otherwise.
  const io::RadioEnd from = own != ids.end() ? own->second : io::RadioEnd{self, 0};
  for (const wire::LinktrackNode& node : frame.nodes) {
    const auto peer = ids.find(static_cast<std::int64_t>(node.id));
    const io::RadioEnd to =
        peer != ids.end() ? peer->second : io::RadioEnd{unknown_radio(node.id), 0};
    if (to.vehicle == from.vehicle) continue;  // two radios of one vehicle
    sensor::RangeSample sample;
    sample.t = t;
    sample.from = from.vehicle;
    sample.to = to.vehicle;
    sample.from_antenna = from.antenna;
    sample.to_antenna = to.antenna;
    sample.range_m = node.range_m;
    sample.rssi_dbm = node.rx_rssi_dbm;
    sample.first_path_dbm = node.fp_rssi_dbm;
    out.push_back(sample);
  }
}

}  // namespace rali::drive
