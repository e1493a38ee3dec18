#include "rali/drive/input/recording_chain.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/input/sorted_source.hpp"

namespace rali::drive {
namespace {

/// A longer pause between two files means two drives.
constexpr double kOneDriveS = 3600.0;

bool is_static_tf(const io::Topic& topic, wire::MessageKind kind) {
  return kind == wire::MessageKind::kTf && topic.name.ends_with("tf_static");
}

Finding file_finding(const std::string& path, std::string text) {
  Finding f;
  f.id = "D19";
  f.topic = path;
  f.text = std::move(text);
  return f;
}

}  // namespace

RecordingChain::RecordingChain(std::vector<std::string> paths, const InputOptions& options)
    : paths_(std::move(paths)),
      lidar_topic_(options.lidar_topic),
      imu_topic_(options.imu_topic),
      vehicle_(options.vehicle),
      ranges_(options.ranges),
      max_s_(options.duration_s > 0.0 ? options.start_s + options.duration_s : 0.0),
      clock_set_(paths_.size(), false) {}

Result<RecordingChain> RecordingChain::open(std::vector<std::string> paths,
                                            const InputOptions& options) {
  if (paths.empty()) return fail(ErrorCode::kUsage, options.vehicle, "no recording given");
  RecordingChain chain(std::move(paths), options);
  chain.sort_files();
  if (Status status = chain.open_file(0); !status) return tl::make_unexpected(status.error());
  return chain;
}

/// Sorts files of one drive that are given in the wrong order, if their indexes show when they were
/// recorded. Two drives with unrelated clocks stay as given.
void RecordingChain::sort_files() {
  if (paths_.size() < 2) return;
  std::vector<std::pair<std::pair<Time, Time>, std::string>> files;
  for (const std::string& path : paths_) {
    const auto source = io::open_recording(path);
    if (!source || !(*source)->span()) return;
    files.emplace_back(*(*source)->span(), path);
  }
  const auto earlier = [](const auto& a, const auto& b) { return a.first < b.first; };
  if (std::is_sorted(files.begin(), files.end(), earlier)) return;
  std::stable_sort(files.begin(), files.end(), earlier);
  for (std::size_t i = 1; i < files.size(); ++i) {
    const double pause_s = files[i].first.first.s() - files[i - 1].first.second.s();
    if (pause_s < -io::kOrderSlackS || pause_s > kOneDriveS) return;
  }
  for (std::size_t i = 0; i < files.size(); ++i) paths_[i] = files[i].second;
  Finding f = file_finding(paths_.front(),
                           "the recordings are not given in order of time; read "
                           "in the order in which they were recorded");
  f.vehicle = vehicle_;
  found_.push_back(std::move(f));
}

Status RecordingChain::open_file(std::size_t index) {
  const auto wanted = [](const std::string& setting, const std::string& name) {
    return setting == "auto" || setting == name;
  };
  Result<OrderedRecording> opened = open_in_order(
      paths_[index],
      [lidar = lidar_topic_, imu = imu_topic_, ranges = ranges_, wanted](const io::Topic& topic) {
        const wire::MessageKind kind = wire::message_kind(topic.type);
        if (wire::is_cloud(kind)) return wanted(lidar, topic.name);
        if (kind == wire::MessageKind::kImu) return wanted(imu, topic.name);
        if (kind == wire::MessageKind::kLinktrack || kind == wire::MessageKind::kRaliRange) {
          return ranges && ranges->topic_of(topic.name) != nullptr;
        }
        return is_static_tf(topic, kind);
      },
      max_s_);
  if (!opened) return tl::make_unexpected(opened.error());
  file_ = index;
  source_ = std::move(opened->source);
  clock_set_[index] = opened->order == MessageOrder::kClockSet;
  seen_.clear();
  return {};
}

void RecordingChain::close_file(InputGaps& gaps, FindingList& findings) {
  const io::SourceHealth& health = source_->health();
  gaps.undecodable += health.messages_skipped;
  gaps.bytes_lost += health.bytes_lost;
  if (health.truncated || health.messages_skipped > 0 || health.bytes_lost > 0) gaps.damaged = true;
  for (const Finding& f : health.findings) {
    findings.push_back(f);
    findings.back().vehicle = vehicle_;
  }
  source_.reset();
}

bool RecordingChain::next(RecordedMessage& out, InputGaps& gaps, FindingList& findings) {
  findings.insert(findings.end(), found_.begin(), found_.end());
  found_.clear();
  while (source_) {
    io::RawMessage raw;
    const Result<bool> got = source_->next(raw);
    if (got && *got) {
      const io::Topic& topic = source_->topics()[raw.topic];
      seen_.resize(std::max(seen_.size(), raw.topic + 1), 0);
      ++seen_[raw.topic];
      out.kind = wire::message_kind(topic.type);
      out.topic = topic.name;
      out.type = topic.type;
      out.encoding = topic.encoding;
      out.t_record = raw.t_record;
      out.data = raw.data;
      out.offset = raw.offset;
      out.file = file_;
      return true;
    }
    if (!got) {
      gaps.damaged = true;
      findings.push_back(file_finding(paths_[file_], got.error().message()));
    }
    close_file(gaps, findings);
    for (std::size_t index = file_ + 1; index < paths_.size() && !source_; ++index) {
      if (Status status = open_file(index); !status) {
        gaps.damaged = true;
        findings.push_back(file_finding(paths_[index], status.error().message()));
      }
    }
  }
  file_ = paths_.size();
  return false;
}

std::vector<TopicCount> RecordingChain::topics() const {
  std::vector<TopicCount> counts;
  if (!source_) return counts;
  const std::vector<io::Topic>& topics = source_->topics();
  for (std::size_t i = 0; i < topics.size(); ++i) {
    TopicCount count;
    count.name = topics[i].name;
    count.type = topics[i].type;
    count.kind = wire::message_kind(topics[i].type);
    count.exact = topics[i].messages.has_value();
    count.messages = topics[i].messages.value_or(i < seen_.size() ? seen_[i] : 0);
    counts.push_back(std::move(count));
  }
  return counts;
}

double RecordingChain::progress() const {
  const double within = source_ ? source_->progress() : 0.0;
  return std::min(1.0, (static_cast<double>(file_) + within) / static_cast<double>(paths_.size()));
}

}  // namespace rali::drive
