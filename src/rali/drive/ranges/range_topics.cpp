#include "rali/drive/ranges/range_topics.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "rali/drive/ranges/linktrack_samples.hpp"
#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

/// RangeSample: 0 means unknown; in the message NaN does.
double known_dbm(float value) { return std::isfinite(value) ? static_cast<double>(value) : 0.0; }

/// The antenna of a name; an unknown name becomes kNobody.
io::RadioEnd end_of(const io::RadioNames& names, const std::string& vehicle,
                    const std::string& antenna) {
  const auto with_antenna = names.find(vehicle + '/' + antenna);
  if (with_antenna != names.end()) return with_antenna->second;
  const auto alone = names.find(vehicle);
  return alone != names.end() ? alone->second : io::RadioEnd{kNobody, 0};
}

}  // namespace

bool RangeTopics::wants(const RecordedMessage& message) const {
  const bool ranges = message.kind == wire::MessageKind::kLinktrack ||
                      message.kind == wire::MessageKind::kRaliRange;
  return ranges && options_ && options_->topic_of(message.topic) != nullptr;
}

Status RangeTopics::take(const RecordedMessage& message, std::vector<sensor::RangeSample>& out) {
  const RangeTopic* const source = options_->topic_of(message.topic);
  if (message.kind == wire::MessageKind::kRaliRange) {
    const Result<wire::RangeMessage> range = wire::decode_range(message.data, message.encoding);
    if (!range) return tl::make_unexpected(range.error());
    take_range(*range, message, out);
    return {};
  }
  const Result<wire::LinktrackFrame> frame =
      wire::decode_linktrack(message.type, message.data, message.encoding);
  if (!frame) return tl::make_unexpected(frame.error());
  take_linktrack(*source, *frame, message, out);
  return {};
}

Time RangeTopics::stamp_of(Time header, const wire::LinktrackFrame& frame,
                           const RecordedMessage& message) {
  const bool by_header = options_->stamp == RangeStamp::kAuto && header.ns != 0;
  if (by_header) return header - options_->latency();
  if (options_->stamp == RangeStamp::kRecord)
    return message.t_record + clock_ahead_ - options_->latency();
  auto clock = stamps_.find(message.topic);
  if (clock == stamps_.end()) {
    clock = stamps_.emplace(std::string(message.topic), RadioStamps(options_->arrival)).first;
  }
  return clock->second.host_time(frame, message.t_record) + clock_ahead_ - options_->latency();
}

void RangeTopics::take_linktrack(const RangeTopic& source, const wire::LinktrackFrame& frame,
                                 const RecordedMessage& message,
                                 std::vector<sensor::RangeSample>& out) {
  append_linktrack(frame, stamp_of(frame.stamp, frame, message), source.ids, self_, out);
}

void RangeTopics::take_range(const wire::RangeMessage& range, const RecordedMessage& message,
                             std::vector<sensor::RangeSample>& out) const {
  const bool by_header = options_->stamp != RangeStamp::kRecord && range.stamp.ns != 0;
  const io::RadioEnd from = end_of(options_->names, range.from, range.antenna);
  const io::RadioEnd to = end_of(options_->names, range.to, "");
  if (from.vehicle == to.vehicle) return;
  sensor::RangeSample sample;
  sample.t = (by_header ? range.stamp : message.t_record + clock_ahead_) - options_->latency();
  sample.from = from.vehicle;
  sample.to = to.vehicle;
  sample.from_antenna = from.antenna;
  sample.to_antenna = to.antenna;
  sample.range_m = range.range_m;
  sample.sigma_m =
      std::isfinite(range.sigma_m) ? std::max(0.0, static_cast<double>(range.sigma_m)) : 0.0;
  sample.rssi_dbm = known_dbm(range.rssi_dbm);
  sample.first_path_dbm = known_dbm(range.rssi_first_path_dbm);
  out.push_back(sample);
}

}  // namespace rali::drive
