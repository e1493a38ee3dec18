#include "rali/drive/input/topic_choice.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace rali::drive {
namespace {

using wire::MessageKind;

std::string listed(const std::vector<const TopicCount*>& topics) {
  std::string text;
  for (const TopicCount* topic : topics) {
    if (!text.empty()) text += ", ";
    text += topic->name;
    if (topic->exact || topic->messages > 0) {
      text += fmt::format(" ({}{})", topic->messages, topic->exact ? "" : " so far");
    }
  }
  return text;
}

template <class Predicate>
std::vector<const TopicCount*> matching(std::span<const TopicCount> topics, Predicate predicate) {
  std::vector<const TopicCount*> found;
  for (const TopicCount& topic : topics) {
    // A topic that was announced but never written to is no candidate.
    if (topic.exact && topic.messages == 0) continue;
    if (predicate(topic)) found.push_back(&topic);
  }
  std::sort(found.begin(), found.end(),
            [](const TopicCount* a, const TopicCount* b) { return a->name < b->name; });
  return found;
}

/// The error if no topic holds points.
tl::unexpected<Error> no_cloud(std::span<const TopicCount> topics, const std::string& file) {
  const auto unreadable =
      matching(topics, [](const TopicCount& t) { return !wire::kind_advice(t.kind).empty(); });
  if (!unreadable.empty()) {
    return fail(ErrorCode::kInput, file,
                fmt::format("{} holds {}", unreadable.front()->name,
                            wire::kind_advice(unreadable.front()->kind)));
  }
  const auto all = matching(topics, [](const TopicCount&) { return true; });
  if (all.empty()) return fail(ErrorCode::kInput, file, "no messages", "Is the recording empty?");
  return fail(ErrorCode::kInput, file, fmt::format("no point cloud topic among {}", listed(all)),
              "RaLI needs sensor_msgs/PointCloud2 or Livox CustomMsg.");
}

Result<std::string> named(std::span<const TopicCount> topics, const std::string& name, bool cloud,
                          const std::string& file) {
  const char* what = cloud ? "point cloud" : "IMU";
  const auto fits = [&](const TopicCount& t) {
    return cloud ? wire::is_cloud(t.kind) : t.kind == MessageKind::kImu;
  };
  for (const TopicCount& topic : topics) {
    if (topic.name != name) continue;
    if (fits(topic)) return name;
    const std::string_view advice = wire::kind_advice(topic.kind);
    return fail(ErrorCode::kInput, file,
                advice.empty() ? fmt::format("{} is a {}, not a {}", name, topic.type, what)
                               : fmt::format("{} holds {}", name, advice));
  }
  const auto others = matching(topics, fits);
  return fail(ErrorCode::kInput, file, fmt::format("no topic {}", name),
              others.empty() ? fmt::format("There is no {} topic at all.", what)
                             : fmt::format("There is {}.", listed(others)));
}

}  // namespace

Result<TopicChoice> choose_topics(std::span<const TopicCount> topics, const InputOptions& options,
                                  const std::string& file) {
  TopicChoice choice;
  if (options.lidar_topic != "auto") {
    Result<std::string> lidar = named(topics, options.lidar_topic, true, file);
    if (!lidar) return tl::make_unexpected(lidar.error());
    choice.lidar = *lidar;
  } else {
    const auto clouds =
        matching(topics, [](const TopicCount& t) { return wire::is_cloud(t.kind); });
    if (clouds.empty()) return no_cloud(topics, file);
    if (clouds.size() > 1) {
      return fail(
          ErrorCode::kInput, file,
          fmt::format("{} point cloud topics: {}", clouds.size(), listed(clouds)),
          fmt::format("Choose with vehicles.{}.lidar.topic or --lidar-topic.", options.vehicle));
    }
    choice.lidar = clouds.front()->name;
  }
  if (options.imu_topic == "none") return choice;
  if (options.imu_topic != "auto") {
    Result<std::string> imu = named(topics, options.imu_topic, false, file);
    if (!imu) return tl::make_unexpected(imu.error());
    choice.imu = *imu;
    return choice;
  }
  const auto imus =
      matching(topics, [](const TopicCount& t) { return t.kind == MessageKind::kImu; });
  if (imus.size() > 1) {
    return fail(ErrorCode::kInput, file,
                fmt::format("{} IMU topics: {}", imus.size(), listed(imus)),
                fmt::format("Choose with vehicles.{}.imu.topic or --imu-topic.", options.vehicle));
  }
  if (!imus.empty()) choice.imu = imus.front()->name;
  return choice;
}

}  // namespace rali::drive
