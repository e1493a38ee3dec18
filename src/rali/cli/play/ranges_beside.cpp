#include "rali/cli/play/ranges_beside.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::cli {
namespace {

constexpr const char* kTopic = "/uwb/ranges";
constexpr const char* kType = "rali_msgs/msg/Range";
/// Delay of a frame of three nodes through a serial port and a driver.
const Duration kDelay = Duration::from_s(0.003);

float number_of(std::string_view text) {
  float value = std::numeric_limits<float>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

class RangesBeside final : public io::MessageSource {
 public:
  RangesBeside(std::unique_ptr<io::MessageSource> recording, std::vector<wire::RangeMessage> ranges)
      : recording_(std::move(recording)), ranges_(std::move(ranges)) {
    list_topics();
  }

  [[nodiscard]] const std::vector<io::Topic>& topics() const override { return topics_; }

  void select(std::function<bool(const io::Topic&)> keep) override {
    wanted_ = keep(topics_.front());
    recording_->select(std::move(keep));
  }

  [[nodiscard]] Result<bool> next(io::RawMessage& out) override {
    if (!held_) {
      const Result<bool> more = recording_->next(message_);
      if (!more || !*more) return more;
      if (recording_->topics().size() + 1 != topics_.size()) list_topics();
      held_ = true;
    }
    while (wanted_ && at_ < ranges_.size()) {
      const Time t = ranges_[at_].stamp + kDelay;
      if (t > message_.t_record) break;
      bytes_ = wire::encode(ranges_[at_++], wire::Encoding::kCdr);
      // Ranges measured before the recording began are not played.
      if (!began_ && t < message_.t_record) continue;
      out = {0, t, bytes_, 0};
      return true;
    }
    began_ = true;
    held_ = false;
    out = message_;
    ++out.topic;
    return true;
  }

  [[nodiscard]] const io::SourceHealth& health() const override { return recording_->health(); }

  [[nodiscard]] double progress() const override { return recording_->progress(); }

  [[nodiscard]] std::optional<std::pair<Time, Time>> span() const override {
    return recording_->span();
  }

  [[nodiscard]] std::optional<bool> in_order() const override { return recording_->in_order(); }

 private:
  void list_topics() {
    io::Topic topic;
    topic.name = kTopic;
    topic.type = kType;
    topic.encoding = wire::Encoding::kCdr;
    topic.encoding_name = "cdr";
    topic.definition = wire::message_definition(kType, wire::Encoding::kCdr);
    topics_ = {std::move(topic)};
    for (const io::Topic& other : recording_->topics()) topics_.push_back(other);
  }

  std::unique_ptr<io::MessageSource> recording_;
  std::vector<wire::RangeMessage> ranges_;  ///< by time
  std::size_t at_ = 0;
  std::vector<io::Topic> topics_;
  bool wanted_ = true, held_ = false, began_ = false;
  io::RawMessage message_;
  wire::Bytes bytes_;
};

}  // namespace

Result<std::unique_ptr<io::MessageSource>> with_ranges(std::unique_ptr<io::MessageSource> recording,
                                                       const std::string& csv,
                                                       const std::string& vehicle) {
  auto reader = io::CsvReader::open(csv);
  if (!reader) return tl::make_unexpected(reader.error());
  int columns[4] = {};
  const char* names[] = {"stamp_s", "from", "to", "range_m"};
  for (int k = 0; k < 4; ++k) {
    const Result<int> column = reader->require(names[k]);
    if (!column) return tl::make_unexpected(column.error());
    columns[k] = *column;
  }
  const int rssi = reader->column("rssi_dbm"), first = reader->column("first_path_dbm");
  std::vector<wire::RangeMessage> ranges;
  for (;;) {
    const Result<bool> more = reader->next();
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    wire::RangeMessage range;
    range.from = reader->cell(columns[1]);
    range.to = reader->cell(columns[2]);
    const auto t = io::parse_stamp(reader->cell(columns[0]));
    const float range_m = number_of(reader->cell(columns[3]));
    if (!t || !std::isfinite(range_m)) {
      return fail(ErrorCode::kInput, reader->where(), "is no range");
    }
    if (range.from != vehicle && range.to != vehicle) continue;
    range.stamp = *t;
    range.range_m = static_cast<double>(range_m);
    range.rssi_dbm = number_of(reader->cell(rssi));
    range.rssi_first_path_dbm = number_of(reader->cell(first));
    ranges.push_back(std::move(range));
  }
  if (ranges.empty()) {
    return fail(ErrorCode::kInput, csv, fmt::format("holds no range of '{}'", vehicle),
                "Name the vehicle with --vehicle as the file does.");
  }
  std::stable_sort(ranges.begin(), ranges.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  return std::unique_ptr<io::MessageSource>(
      std::make_unique<RangesBeside>(std::move(recording), std::move(ranges)));
}

}  // namespace rali::cli
