#include "rali/net/dds_ros_bus.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <map>
#include <string_view>
#include <utility>

#include "rali/net/internal/blob.hpp"
#include "rali/net/internal/dds_config.hpp"
#include "rali/net/internal/dds_domain.hpp"
#include "rali/net/internal/node_info.hpp"
#include "rali/net/internal/ros_inbox.hpp"
#include "rali/net/ros_names.hpp"
#include "rali/net/wall_clock.hpp"

namespace rali::net {
namespace {

constexpr std::string_view kEnclave = "enclave=/;";  // without it ROS 2 ignores a participant
constexpr int kDepthMax = 1000;
constexpr int kRosDomainMax = 232;           // RTPS 9.6.1.1
constexpr std::size_t kEndpointsMax = 1024;  ///< limit of published()

struct Topic {
  dds_entity_t entity = 0;
  const ddsi_sertype* type = nullptr;
};

struct Writer {
  dds_entity_t entity = 0;
  const ddsi_sertype* type = nullptr;
};

/// Context of a listener.
struct Subscription {
  int number = 0;
  RosInbox* inbox = nullptr;
};

QosPtr make_qos(const RosQos& wanted) {
  QosPtr qos(dds_create_qos());
  // 0: publish() never blocks.
  dds_qset_reliability(qos.get(),
                       wanted.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, wanted.depth);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  if (wanted.transient_local) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, wanted.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  }
  return qos;
}

RosQos read_qos(const dds_qos_t* qos) {
  RosQos out;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  if (dds_qget_reliability(qos, &reliability, nullptr)) {
    out.reliable = reliability == DDS_RELIABILITY_RELIABLE;
  }
  if (dds_qget_durability(qos, &durability)) {
    out.transient_local = durability != DDS_DURABILITY_VOLATILE;
  }
  return out;
}

Gid gid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  Gid gid{};
  if (dds_get_guid(entity, &guid) == DDS_RETCODE_OK) {
    std::copy(std::begin(guid.v), std::end(guid.v), gid.begin());
  }
  return gid;
}

void on_data(dds_entity_t reader, void* arg) {
  const auto& subscription = *static_cast<const Subscription*>(arg);
  const Time t = wall_now();
  take_blobs(reader, [&](std::span<const std::uint8_t> cdr) {
    subscription.inbox->put(subscription.number, t, cdr);
  });
}

class DdsRosBus final : public RosBus {
 public:
  explicit DdsRosBus(RosBusOptions options)
      : options_(std::move(options)), blob_counts_(std::make_shared<BlobCounts>()) {
    node_.node_namespace = options_.node_namespace;
    node_.node_name = options_.node_name;
  }

  [[nodiscard]] Status open();

  [[nodiscard]] Result<int> advertise(const RosTopic& topic) override;
  void publish(int publication, std::span<const std::uint8_t> cdr) override;
  [[nodiscard]] Result<int> subscribe(const RosTopic& topic) override;

  [[nodiscard]] std::vector<RosMessage> take(Duration timeout) override {
    return inbox_.take(timeout);
  }

  [[nodiscard]] std::vector<RosTopic> published() const override;
  [[nodiscard]] int readers(int publication) const override;
  [[nodiscard]] RosCounts counts() const override;

 private:
  [[nodiscard]] Result<Topic> dds_topic(const RosTopic& topic);
  [[nodiscard]] Result<Writer> make_writer(const Topic& topic, const RosTopic& wanted);
  void announce();

  RosBusOptions options_;
  std::shared_ptr<BlobCounts> blob_counts_;
  RosInbox inbox_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::atomic<std::uint64_t> published_{0}, refused_{0};
  std::unique_ptr<DdsDomain> domain_;  ///< destroyed first: its listeners use the members above
  std::map<std::pair<std::string, std::string>, Topic> topics_;
  std::vector<Writer> writers_;
  Writer announcement_;
  dds_entity_t publications_ = 0;  ///< built-in reader
  NodeInfo node_;
};

Status DdsRosBus::open() {
  const QosPtr qos(dds_create_qos());
  dds_qset_userdata(qos.get(), kEnclave.data(), kEnclave.size());
  auto domain = DdsDomain::open(cyclone_config(options_), qos.get(), options_.interface);
  if (!domain) return tl::make_unexpected(domain.error());
  domain_ = std::move(*domain);
  node_.participant = gid_of(domain_->participant());
  publications_ = dds_create_reader(domain_->participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                    nullptr, nullptr);
  if (publications_ < 0) {
    return tl::make_unexpected(dds_error("DCPSPublication", "cannot be read", publications_));
  }
  Topic topic;
  topic.entity = create_blob_topic(domain_->participant(), kNodeInfoTopic, kNodeInfoType,
                                   options_.message_bytes_max, blob_counts_, &topic.type);
  if (topic.entity < 0) {
    return tl::make_unexpected(dds_error(kNodeInfoTopic, "cannot be made", topic.entity));
  }
  const auto writer = make_writer(topic, {kNodeInfoTopic, kNodeInfoType, {true, true, 1}});
  if (!writer) return tl::make_unexpected(writer.error());
  announcement_ = *writer;
  announce();
  return {};
}

void DdsRosBus::announce() {
  (void)write_blob(announcement_.entity, announcement_.type,
                   encode_node_info(node_, options_.gid_bytes));
}

Result<Topic> DdsRosBus::dds_topic(const RosTopic& topic) {
  const auto name = dds_topic_name(topic.name);
  const auto type = dds_type_name(topic.type);
  if (!name || !type) {
    return fail(ErrorCode::kInput, topic.name,
                name ? "\"" + topic.type + "\" is no type of ROS 2" : "is no topic of ROS 2",
                "Names are like /v1/odom, types like nav_msgs/msg/Odometry.");
  }
  if (topic.qos.depth < 1 || topic.qos.depth > kDepthMax) {
    return fail(ErrorCode::kInput, topic.name, "has a depth outside 1 to 1000");
  }
  Topic& made = topics_[{*name, *type}];
  if (made.entity > 0) return made;
  made.entity = create_blob_topic(domain_->participant(), *name, *type, options_.message_bytes_max,
                                  blob_counts_, &made.type);
  if (made.entity > 0) return made;
  return tl::make_unexpected(dds_error(topic.name, "cannot be made", made.entity));
}

Result<Writer> DdsRosBus::make_writer(const Topic& topic, const RosTopic& wanted) {
  const QosPtr qos = make_qos(wanted.qos);
  const dds_entity_t entity =
      dds_create_writer(domain_->participant(), topic.entity, qos.get(), nullptr);
  if (entity < 0) return tl::make_unexpected(dds_error(wanted.name, "cannot be written", entity));
  return Writer{entity, topic.type};
}

Result<int> DdsRosBus::advertise(const RosTopic& wanted) {
  const auto topic = dds_topic(wanted);
  if (!topic) return tl::make_unexpected(topic.error());
  const auto writer = make_writer(*topic, wanted);
  if (!writer) return tl::make_unexpected(writer.error());
  writers_.push_back(*writer);
  node_.writers.push_back(gid_of(writer->entity));
  announce();
  return static_cast<int>(writers_.size()) - 1;
}

void DdsRosBus::publish(int publication, std::span<const std::uint8_t> cdr) {
  const Writer& writer = writers_.at(static_cast<std::size_t>(publication));
  const bool sent = write_blob(writer.entity, writer.type, cdr) == DDS_RETCODE_OK;
  ++(sent ? published_ : refused_);
}

Result<int> DdsRosBus::subscribe(const RosTopic& wanted) {
  const auto topic = dds_topic(wanted);
  if (!topic) return tl::make_unexpected(topic.error());
  auto subscription = std::make_unique<Subscription>();
  subscription->number = inbox_.add(wanted.qos.depth);
  subscription->inbox = &inbox_;
  const ListenerPtr listener(dds_create_listener(subscription.get()));
  dds_lset_data_available(listener.get(), on_data);
  subscriptions_.push_back(std::move(subscription));  // kept even if a call below fails
  const QosPtr qos = make_qos(wanted.qos);
  const dds_entity_t reader =
      dds_create_reader(domain_->participant(), topic->entity, qos.get(), listener.get());
  if (reader < 0) return tl::make_unexpected(dds_error(wanted.name, "cannot be read", reader));
  node_.readers.push_back(gid_of(reader));
  announce();
  return subscriptions_.back()->number;
}

std::vector<RosTopic> DdsRosBus::published() const {
  std::vector<void*> samples(kEndpointsMax, nullptr);
  std::vector<dds_sample_info_t> infos(kEndpointsMax);
  const dds_return_t n =
      dds_read_mask(publications_, samples.data(), infos.data(), kEndpointsMax,
                    static_cast<std::uint32_t>(kEndpointsMax),
                    DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  std::map<std::pair<std::string, std::string>, RosTopic> found;
  for (std::size_t i = 0; n > 0 && i < static_cast<std::size_t>(n); ++i) {
    if (!infos[i].valid_data) continue;
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    if (std::equal(node_.participant.begin(), node_.participant.end(),
                   std::begin(endpoint.participant_key.v))) {
      continue;
    }
    const auto name = ros_topic_name(endpoint.topic_name);
    const auto type = ros_type_name(endpoint.type_name);
    if (!name || !type) continue;
    const auto [at, is_new] =
        found.try_emplace({*name, *type}, RosTopic{*name, *type, read_qos(endpoint.qos)});
    if (!is_new) {  // only what all of its writers offer
      const RosQos other = read_qos(endpoint.qos);
      at->second.qos.reliable = at->second.qos.reliable && other.reliable;
      at->second.qos.transient_local = at->second.qos.transient_local && other.transient_local;
    }
  }
  if (n > 0) (void)dds_return_loan(publications_, samples.data(), n);
  std::vector<RosTopic> out;
  for (auto& [key, topic] : found) out.push_back(std::move(topic));
  return out;
}

int DdsRosBus::readers(int publication) const {
  dds_publication_matched_status_t status{};
  const dds_entity_t writer = writers_.at(static_cast<std::size_t>(publication)).entity;
  if (dds_get_publication_matched_status(writer, &status) != DDS_RETCODE_OK) return 0;
  return static_cast<int>(status.current_count);
}

RosCounts DdsRosBus::counts() const {
  RosCounts out;
  out.published = published_;
  out.refused = refused_;
  out.malformed = blob_counts_->malformed;
  inbox_.add_counts(out);
  return out;
}

}  // namespace

Result<std::unique_ptr<RosBus>> open_dds_ros_bus(const RosBusOptions& options) {
  if (const Status status = check(options); !status) return tl::make_unexpected(status.error());
  auto bus = std::make_unique<DdsRosBus>(options);
  if (const Status status = bus->open(); !status) return tl::make_unexpected(status.error());
  return bus;
}

Result<int> parse_ros_domain(const std::string& text, const std::string& where) {
  int domain = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, domain);
  if (error == std::errc() && stop == end && domain >= 0 && domain <= kRosDomainMax) return domain;
  return fail(ErrorCode::kUsage, where, "\"" + text + "\" is no domain of ROS",
              "Set it to 0 to 232.");
}

Result<int> ros_domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  return parse_ros_domain(text, "ROS_DOMAIN_ID");
}

}  // namespace rali::net
