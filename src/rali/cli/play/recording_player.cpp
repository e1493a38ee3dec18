#include "rali/cli/play/recording_player.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "rali/wire/definitions.hpp"
#include "rali/wire/shift_stamps.hpp"

namespace rali::cli {
namespace {

using wire::Encoding;
using wire::MessageKind;

/// A larger step of the record times is a clock adjustment, or a pause of the recorder.
constexpr double kBackMaxS = 1.0, kGapMaxS = 30.0;
constexpr int kCloudDepth = 5, kSampleDepth = 200, kLatchedDepth = 100;
constexpr std::uint64_t kProgressEvery = 64;

bool is_sensor(MessageKind kind) {
  return wire::is_cloud(kind) || kind == MessageKind::kImu || kind == MessageKind::kTf ||
         kind == MessageKind::kLinktrack || kind == MessageKind::kRaliRange;
}

net::RosQos qos_of(MessageKind kind, const std::string& name) {
  if (name.ends_with("/tf_static")) return {true, true, kLatchedDepth};
  return {true, false, wire::is_cloud(kind) ? kCloudDepth : kSampleDepth};
}

}  // namespace

RecordingPlayer::RecordingPlayer(io::MessageSource& source, net::RosBus& bus, PlayOptions options,
                                 PlayClock clock)
    : source_(source), bus_(bus), options_(std::move(options)), clock_(std::move(clock)) {
  source_.select([wanted = options_.topics](const io::Topic& topic) {
    if (wanted.empty()) return is_sensor(wire::message_kind(topic.type));
    return std::find(wanted.begin(), wanted.end(), topic.name) != wanted.end();
  });
}

Status RecordingPlayer::advertise() {
  for (std::size_t i = 0; i < source_.topics().size(); ++i) {
    const io::Topic& topic = source_.topics()[i];
    const bool is_named = std::find(options_.topics.begin(), options_.topics.end(), topic.name) !=
                          options_.topics.end();
    const bool wanted =
        options_.topics.empty() ? is_sensor(wire::message_kind(topic.type)) : is_named;
    if (wanted) static_cast<void>(outlet_of(i));
  }
  const bool is_indexed = !source_.topics().empty();
  if (!is_indexed || !published().empty()) return {};
  std::string found;
  for (const io::Topic& topic : source_.topics()) {
    found += (found.empty() ? "" : ", ") + topic.name + " (" + topic.type + ")";
  }
  return fail(ErrorCode::kInput, "", "no topic of a sensor can be played, only " + found,
              "Name topics with --topic.");
}

std::string RecordingPlayer::name_of(const std::string& topic) const {
  const std::string name = topic.starts_with('/') ? topic : "/" + topic;
  if (options_.vehicle.empty() || name == "/tf" || name == "/tf_static") return name;
  const std::string prefix = "/" + options_.vehicle;
  return name.starts_with(prefix + "/") ? name : prefix + name;
}

std::optional<RecordingPlayer::Outlet> RecordingPlayer::open(const io::Topic& topic) {
  Outlet outlet;
  outlet.name = name_of(topic.name);
  outlet.type = wire::ros2_type_name(topic.type == "tf/tfMessage" ? "tf2_msgs/TFMessage"
                                                                  : std::string_view(topic.type));
  outlet.kind = wire::message_kind(topic.type);
  if (topic.encoding == Encoding::kRos1) {
    const std::string type = wire::ros1_type_name(topic.type);
    const std::string definition = topic.definition.empty()
                                       ? wire::message_definition(type, Encoding::kRos1)
                                       : topic.definition;
    if (definition.empty()) {
      left_out_.push_back(topic.name + ": the recording has no definition of " + type);
      return std::nullopt;
    }
    auto convert = wire::Ros1ToCdr::make(type, definition);
    if (!convert) {
      left_out_.push_back(topic.name + ": " + convert.error().what);
      return std::nullopt;
    }
    outlet.convert = std::move(*convert);
  } else if (topic.encoding != Encoding::kCdr) {
    left_out_.push_back(topic.name + ": its messages are " + topic.encoding_name +
                        ", neither ROS 1 nor CDR");
    return std::nullopt;
  }
  const auto publication =
      bus_.advertise({outlet.name, outlet.type, qos_of(outlet.kind, outlet.name)});
  if (!publication) {
    left_out_.push_back(topic.name + ": " + publication.error().message());
    return std::nullopt;
  }
  outlet.publication = *publication;
  return outlet;
}

RecordingPlayer::Outlet* RecordingPlayer::outlet_of(std::size_t topic) {
  auto known = outlets_.find(topic);
  if (known == outlets_.end()) {
    known = outlets_.emplace(topic, open(source_.topics()[topic])).first;
  }
  return known->second ? &*known->second : nullptr;
}

std::vector<std::string> RecordingPlayer::published() const {
  std::set<std::string> names;  // connections of a bag may share a topic
  for (const auto& [topic, outlet] : outlets_) {
    if (outlet) names.insert(outlet->name);
  }
  return {names.begin(), names.end()};
}

bool RecordingPlayer::is_received() const {
  enum : int { kCloud, kInertial, kOther };

  std::map<int, bool> received;
  for (const auto& [topic, outlet] : outlets_) {
    if (!outlet) continue;
    const int group = wire::is_cloud(outlet->kind)        ? kCloud
                      : outlet->kind == MessageKind::kImu ? kInertial
                                                          : kOther;
    received[group] = received[group] || bus_.readers(outlet->publication) > 0;
  }
  if (received.size() > 1) received.erase(kOther);
  return !received.empty() &&
         std::all_of(received.begin(), received.end(), [](const auto& one) { return one.second; });
}

Time RecordingPlayer::due(Time t_record) {
  const bool is_first = !t_record_0_;
  const double step_s = is_first ? 0.0 : seconds_between(*t_record_last_, t_record);
  if (is_first || step_s < -kBackMaxS || step_s > kGapMaxS) {
    t_record_0_ = t_record;
    t_play_0_ = clock_.now();
  }
  t_record_last_ = t_record;
  const double since_s = seconds_between(*t_record_0_, t_record) / options_.rate;
  return t_play_0_ + Duration::from_s(since_s);
}

std::uint64_t RecordingPlayer::send(const Outlet& outlet, const io::RawMessage& message) {
  std::vector<std::byte> cdr;
  if (outlet.convert) {
    auto converted = outlet.convert->convert(message.data);
    if (!converted) return 0;
    cdr = std::move(*converted);
  } else {
    cdr.assign(message.data.begin(), message.data.end());
  }
  if (options_.restamp) {
    static_cast<void>(wire::shift_stamps(outlet.kind, outlet.type, t_play_0_ - *t_record_0_, cdr));
  }
  bus_.publish(outlet.publication, {reinterpret_cast<const std::uint8_t*>(cdr.data()), cdr.size()});
  return cdr.size();
}

Result<PlayTally> RecordingPlayer::play(
    const std::function<void(double, const PlayTally&)>& on_progress) {
  PlayTally tally;
  io::RawMessage message;
  for (;;) {
    const auto more = source_.next(message);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) return tally;
    const Outlet* outlet = outlet_of(message.topic);
    if (outlet == nullptr) continue;
    const Time t_due = due(message.t_record);
    if (!clock_.sleep_until(t_due)) {
      tally.stopped = true;
      return tally;
    }
    tally.latest = std::max(tally.latest, clock_.now() - t_due);
    const std::uint64_t sent = send(*outlet, message);
    ++(sent > 0 ? tally.messages : tally.damaged);
    tally.bytes += sent;
    if ((tally.messages + tally.damaged) % kProgressEvery == 0) {
      on_progress(source_.progress(), tally);
    }
  }
}

}  // namespace rali::cli
