#include "rali/drive/input/sorted_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/temp_file.hpp"
#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

/// Position of a message in the temporary file.
struct Stored {
  Time key;
  Time t_record;
  std::uint64_t offset = 0;
  std::uint64_t offset_in_file = 0;
  std::uint32_t bytes = 0;
  std::uint32_t topic = 0;
};

/// The header stamp of a message, if it has one.
std::optional<Time> header_stamp(const io::Topic& topic, std::span<const std::byte> data) {
  const wire::MessageKind kind = wire::message_kind(topic.type);
  if (wire::is_cloud(kind)) {
    const auto view = wire::decode_cloud_message(kind, data, topic.encoding);
    return view ? std::optional<Time>(view->stamp) : std::nullopt;
  }
  if (kind == wire::MessageKind::kImu) {
    const auto imu = wire::decode_imu(data, topic.encoding);
    return imu ? std::optional<Time>(imu->sample.t) : std::nullopt;
  }
  std::optional<Time> stamp;
  if (kind == wire::MessageKind::kRaliRange) {
    if (const auto range = wire::decode_range(data, topic.encoding)) stamp = range->stamp;
  } else if (kind == wire::MessageKind::kLinktrack) {
    if (const auto frame = wire::decode_linktrack(topic.type, data, topic.encoding)) {
      stamp = frame->stamp;
    }
  }
  return stamp && stamp->ns != 0 ? stamp : std::nullopt;
}

bool is_sensor(const io::Topic& topic) {
  const wire::MessageKind kind = wire::message_kind(topic.type);
  return wire::is_cloud(kind) || kind == wire::MessageKind::kImu;
}

class SortedSource final : public io::MessageSource {
 public:
  explicit SortedSource(std::unique_ptr<io::MessageSource> source) : source_(std::move(source)) {}

  Status fill(MessageOrder order);

  void note(const std::string& name, MessageOrder order);

  const std::vector<io::Topic>& topics() const override { return source_->topics(); }

  void select(KeepTopic keep) override { keep_ = std::move(keep); }

  Result<bool> next(io::RawMessage& out) override;

  const io::SourceHealth& health() const override { return health_; }

  double progress() const override {
    return stored_.empty() ? 1.0 : static_cast<double>(next_) / static_cast<double>(stored_.size());
  }

  std::optional<std::pair<Time, Time>> span() const override {
    if (stored_.empty()) return std::nullopt;
    return std::make_pair(stored_.front().key, stored_.back().key);
  }

  std::optional<bool> in_order() const override { return true; }

 private:
  Time key_of(const io::RawMessage& message, MessageOrder order);

  std::unique_ptr<io::MessageSource> source_;
  std::shared_ptr<io::ByteSource> bytes_;
  std::vector<Stored> stored_;
  std::vector<std::byte> data_;
  io::SourceHealth health_;
  KeepTopic keep_;
  Time last_key_{std::numeric_limits<std::int64_t>::min()};
  std::size_t next_ = 0;
  std::size_t late_ = 0;  ///< messages that the ordering window could not have sorted
};

Time SortedSource::key_of(const io::RawMessage& message, MessageOrder order) {
  const io::Topic& topic = source_->topics()[message.topic];
  if (wire::message_kind(topic.type) == wire::MessageKind::kTf) {
    return Time{std::numeric_limits<std::int64_t>::min()};
  }
  if (order == MessageOrder::kHeader) {
    last_key_ = header_stamp(topic, message.data).value_or(last_key_);
    return last_key_;
  }
  return message.t_record;
}

/// The file is unlinked from its folder afterwards; the open handle keeps the bytes.
Status SortedSource::fill(MessageOrder order) {
  Result<io::TempFile> file = io::TempFile::create();
  if (!file) return tl::make_unexpected(file.error());
  io::RawMessage message;
  std::uint64_t offset = 0;
  double newest_s = -std::numeric_limits<double>::infinity();
  while (true) {
    const Result<bool> more = source_->next(message);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    Stored stored;
    stored.key = key_of(message, order);
    stored.t_record = order == MessageOrder::kHeader ? stored.key : message.t_record;
    stored.offset = offset;
    stored.offset_in_file = message.offset;
    stored.bytes = static_cast<std::uint32_t>(message.data.size());
    stored.topic = static_cast<std::uint32_t>(message.topic);
    if (Status s = file->write(message.data); !s) return s;
    offset += message.data.size();
    if (newest_s - stored.key.s() > io::kOrderSlackS) ++late_;
    newest_s = std::max(newest_s, stored.key.s());
    stored_.push_back(stored);
  }
  std::stable_sort(stored_.begin(), stored_.end(),
                   [](const Stored& a, const Stored& b) { return a.key < b.key; });
  health_ = source_->health();
  Result<std::shared_ptr<io::ByteSource>> bytes = io::open_file_bytes(file->path());
  if (!bytes) return tl::make_unexpected(bytes.error());
  bytes_ = std::move(*bytes);
  return {};
}

void SortedSource::note(const std::string& name, MessageOrder order) {
  Finding f;
  f.id = "D19";
  f.text = fmt::format(
      "{}: {} of {} lie out of order of time in the file; all are read sorted by {}", name, late_,
      counted(stored_.size(), "message"),
      order == MessageOrder::kHeader ? "the stamps of their headers" : "their record times");
  f.remedy = "Nothing is lost by that; it takes room in TMPDIR for the messages";
  f.value = static_cast<double>(late_);
  health_.findings.push_back(std::move(f));
}

Result<bool> SortedSource::next(io::RawMessage& out) {
  while (next_ < stored_.size()) {
    const Stored& stored = stored_[next_++];
    if (keep_ && !keep_(topics()[stored.topic])) continue;
    data_.resize(stored.bytes);
    if (Status s = bytes_->read(stored.offset, data_); !s) return tl::make_unexpected(s.error());
    out.topic = stored.topic;
    out.t_record = stored.t_record;
    out.data = data_;
    out.offset = stored.offset_in_file;
    return true;
  }
  return false;
}

/// How far stamps are read; 0: to the end.
struct Look {
  double seconds = 0.0;
  std::size_t messages = 0;
  std::uint64_t bytes = 0;
};

constexpr Look kBeginning{3.0, 2000, 64U << 20};

/// The stamps of clouds and inertial data.
std::vector<TopicStamp> read_stamps(io::MessageSource& source, const Look& look) {
  std::vector<TopicStamp> stamps;
  std::optional<double> start_s;
  std::uint64_t bytes = 0;
  io::RawMessage message;
  while (source.next(message).value_or(false)) {
    const io::Topic& topic = source.topics()[message.topic];
    if (is_sensor(topic)) {
      const Time header = header_stamp(topic, message.data).value_or(message.t_record);
      stamps.push_back({message.topic,
                        wire::is_cloud(wire::message_kind(topic.type)),
                        {header, message.t_record}});
    }
    bytes += message.data.size();
    start_s = start_s.value_or(message.t_record.s());
    const double since_s = std::abs(message.t_record.s() - *start_s);
    if ((look.seconds > 0.0 && since_s > look.seconds) ||
        (look.messages > 0 && stamps.size() >= look.messages) ||
        (look.bytes > 0 && bytes > look.bytes)) {
      break;
    }
  }
  return stamps;
}

/// The recorder has one clock for all topics; each sensor may have its own.
bool any_late(const std::vector<TopicStamp>& stamps) {
  std::vector<StampPair> all;
  std::map<std::size_t, std::vector<StampPair>> topics;
  for (const TopicStamp& s : stamps) {
    all.push_back(s.stamp);
    topics[s.topic].push_back(s.stamp);
  }
  return late_stamps(all, &StampPair::record) > 0 ||
         std::any_of(topics.begin(), topics.end(), [](const auto& topic) {
           return late_stamps(topic.second, &StampPair::header) > 0;
         });
}

Result<std::unique_ptr<io::MessageSource>> open_kept(const std::string& path,
                                                     const KeepTopic& keep) {
  Result<std::unique_ptr<io::MessageSource>> source = io::open_recording(path);
  if (source) (*source)->select(keep);
  return source;
}

}  // namespace

Result<std::unique_ptr<io::MessageSource>> sort_messages(std::unique_ptr<io::MessageSource> source,
                                                         const std::string& name,
                                                         MessageOrder order) {
  auto sorted = std::make_unique<SortedSource>(std::move(source));
  if (Status s = sorted->fill(order); !s) return tl::make_unexpected(s.error());
  sorted->note(name, order);
  return sorted;
}

Result<OrderedRecording> open_in_order(const std::string& path, const KeepTopic& keep,
                                       double max_s) {
  Result<std::unique_ptr<io::MessageSource>> source = open_kept(path, keep);
  if (!source) return tl::make_unexpected(source.error());
  const bool indexed = (*source)->in_order().value_or(false);
  const Look wanted{max_s, 0, 0};
  const std::vector<TopicStamp> stamps = read_stamps(**source, indexed ? kBeginning : wanted);
  OrderedRecording out;
  if (!indexed) {
    out.order = decide_message_order(stamps);
  } else if (any_late(stamps)) {
    source = open_kept(path, keep);
    if (!source) return tl::make_unexpected(source.error());
    out.order = decide_message_order(read_stamps(**source, wanted));
  }
  source = open_kept(path, keep);
  if (!source) return tl::make_unexpected(source.error());
  out.source = std::move(*source);
  if (out.order != MessageOrder::kRecordTime && out.order != MessageOrder::kHeader) return out;
  source = sort_messages(std::move(out.source), path, out.order);
  if (!source) return tl::make_unexpected(source.error());
  out.source = std::move(*source);
  return out;
}

}  // namespace rali::drive
