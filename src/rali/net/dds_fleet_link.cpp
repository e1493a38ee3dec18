#include "rali/net/dds_fleet_link.hpp"

#include <array>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "rali/net/internal/blob.hpp"
#include "rali/net/internal/dds_config.hpp"
#include "rali/net/internal/dds_domain.hpp"
#include "rali/net/internal/fleet_inbox.hpp"
#include "rali/net/wall_clock.hpp"

namespace rali::net {
namespace {

constexpr const char* kSealedType = "rali_msgs::msg::dds_::Sealed_";
constexpr const char* kToAll = "all";
constexpr int kBulkSamples = 64;   ///< in transit to one vehicle (middleware 4.1)
constexpr int kReaderDepth = 256;  ///< taken out one by one on arrival

struct Channel {
  Urgency urgency;
  const char* topic;
};

constexpr std::array<Channel, 3> kChannels{{{Urgency::kRole, "rt/rali/role"},
                                            {Urgency::kStatus, "rt/rali/status"},
                                            {Urgency::kBulk, "rt/rali/bulk"}}};

std::string partition_of(VehicleId vehicle) { return fmt::format("v{}", vehicle.value); }

/// DDS partitions keep traffic for one vehicle from the others.
QosPtr make_qos(bool is_reliable, int depth, const std::vector<std::string>& partitions) {
  QosPtr qos(dds_create_qos());
  dds_qset_reliability(qos.get(),
                       is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  std::vector<const char*> names;
  for (const std::string& partition : partitions) names.push_back(partition.c_str());
  dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
  return qos;
}

/// Context of a listener.
struct Source {
  Urgency urgency = Urgency::kRole;
  FleetInbox* inbox = nullptr;
};

void on_data(dds_entity_t reader, void* arg) {
  const auto& source = *static_cast<const Source*>(arg);
  const Time t = wall_now();
  take_blobs(reader,
             [&](std::span<const std::uint8_t> cdr) { source.inbox->put(source.urgency, t, cdr); });
}

std::vector<KnownSender> senders_of(const FleetLinkOptions& options) {
  std::vector<KnownSender> out;
  for (const FleetPeer& peer : options.peers) out.push_back({peer.id, peer.epoch_min});
  return out;
}

EnvelopeOpener opener_of(const FleetLinkOptions& options) {
  EnvelopeOpener opener(options.self, options.key, senders_of(options));
  opener.recall(options.seen);
  return opener;
}

std::vector<VehicleId> peers_of(const FleetLinkOptions& options) {
  std::vector<VehicleId> out;
  for (const FleetPeer& peer : options.peers) out.push_back(peer.id);
  return out;
}

class DdsFleetLink final : public FleetLink {
 public:
  explicit DdsFleetLink(FleetLinkOptions options)
      : options_(std::move(options)),
        sealer_(options_.self, options_.epoch, options_.key),
        blob_counts_(std::make_shared<BlobCounts>()),
        inbox_(opener_of(options_), peers_of(options_), options_.queue_bytes_max) {
    for (const FleetPeer& peer : options_.peers) sent_[peer.id].peer = peer.id;
  }

  [[nodiscard]] Status open();

  [[nodiscard]] bool send(std::optional<VehicleId> to, Urgency urgency,
                          std::span<const std::uint8_t> bytes) override;

  [[nodiscard]] std::vector<Arrived> take() override { return inbox_.take(); }

  bool wait(Duration timeout) override { return inbox_.wait(timeout); }

  [[nodiscard]] std::vector<LinkCounts> counts() const override;

  [[nodiscard]] std::vector<SeenCounter> seen() const override { return inbox_.seen(); }

  [[nodiscard]] std::uint64_t strangers() const override {
    return inbox_.strangers() + blob_counts_->malformed;
  }

 private:
  using Destination = std::pair<std::uint16_t, Urgency>;  ///< a vehicle or kEveryone

  [[nodiscard]] Status open_channel(const Channel& channel);
  [[nodiscard]] Status add_writer(const Channel& channel, std::uint16_t to,
                                  const std::string& partition);
  [[nodiscard]] Status add_reader(const Channel& channel);
  [[nodiscard]] bool write(std::uint16_t to, Urgency urgency, std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool send_one(VehicleId to, Urgency urgency, std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool is_there(VehicleId peer) const;

  FleetLinkOptions options_;
  EnvelopeSealer sealer_;
  std::shared_ptr<BlobCounts> blob_counts_;
  FleetInbox inbox_;
  std::array<Source, kChannels.size()> sources_{};
  std::unique_ptr<DdsDomain> domain_;  ///< destroyed first: its listeners use the members above
  std::array<dds_entity_t, kChannels.size()> topics_{};
  std::array<const ddsi_sertype*, kChannels.size()> types_{};
  std::map<Destination, dds_entity_t> writers_;
  std::map<VehicleId, LinkCounts> sent_;
};

std::size_t index_of(Urgency urgency) { return static_cast<std::size_t>(urgency); }

Status DdsFleetLink::open() {
  auto domain = DdsDomain::open(cyclone_config(options_), nullptr, options_.address);
  if (!domain) return tl::make_unexpected(domain.error());
  domain_ = std::move(*domain);
  for (const Channel& channel : kChannels) {
    if (const Status status = open_channel(channel); !status) return status;
  }
  return {};
}

Status DdsFleetLink::open_channel(const Channel& channel) {
  const std::size_t i = index_of(channel.urgency);
  topics_[i] = create_blob_topic(domain_->participant(), channel.topic, kSealedType,
                                 options_.message_bytes_max + kEnvelopeBytes + kSampleHeaderBytes,
                                 blob_counts_, &types_[i]);
  if (topics_[i] < 0) {
    return tl::make_unexpected(dds_error(channel.topic, "cannot be made", topics_[i]));
  }
  if (Status status = add_reader(channel); !status) return status;
  for (const FleetPeer& peer : options_.peers) {
    if (Status status = add_writer(channel, peer.id.value, partition_of(peer.id)); !status) {
      return status;
    }
  }
  // Facts have no common writer: one disconnected vehicle would block all others.
  if (channel.urgency == Urgency::kBulk) return {};
  return add_writer(channel, kEveryone, kToAll);
}

Status DdsFleetLink::add_writer(const Channel& channel, std::uint16_t to,
                                const std::string& partition) {
  const bool is_bulk = channel.urgency == Urgency::kBulk;
  const QosPtr qos = make_qos(is_bulk, kBulkSamples, {partition});
  if (is_bulk) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
    dds_qset_resource_limits(qos.get(), kBulkSamples, DDS_LENGTH_UNLIMITED, kBulkSamples);
  }
  const dds_entity_t writer = dds_create_writer(
      domain_->participant(), topics_[index_of(channel.urgency)], qos.get(), nullptr);
  if (writer < 0) {
    return tl::make_unexpected(dds_error(channel.topic, "cannot be written", writer));
  }
  writers_[{to, channel.urgency}] = writer;
  return {};
}

Status DdsFleetLink::add_reader(const Channel& channel) {
  Source& source = sources_[index_of(channel.urgency)];
  source = {channel.urgency, &inbox_};
  const ListenerPtr listener(dds_create_listener(&source));
  dds_lset_data_available(listener.get(), on_data);
  const QosPtr qos = make_qos(channel.urgency == Urgency::kBulk, kReaderDepth,
                              {partition_of(options_.self), kToAll});
  const dds_entity_t reader = dds_create_reader(
      domain_->participant(), topics_[index_of(channel.urgency)], qos.get(), listener.get());
  if (reader >= 0) return {};
  return tl::make_unexpected(dds_error(channel.topic, "cannot be read", reader));
}

bool DdsFleetLink::write(std::uint16_t to, Urgency urgency, std::span<const std::uint8_t> bytes) {
  if (bytes.size() > options_.message_bytes_max) return false;
  const std::vector<std::uint8_t> sample = encode_sealed(sealer_.seal(to, urgency, bytes));
  return write_blob(writers_.at({to, urgency}), types_[index_of(urgency)], sample) ==
         DDS_RETCODE_OK;
}

bool DdsFleetLink::is_there(VehicleId peer) const {
  dds_publication_matched_status_t status{};
  const dds_entity_t writer = writers_.at({peer.value, Urgency::kBulk});
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}

bool DdsFleetLink::send_one(VehicleId to, Urgency urgency, std::span<const std::uint8_t> bytes) {
  LinkCounts& counts = sent_[to];
  const bool taken = (urgency != Urgency::kBulk || is_there(to)) && write(to.value, urgency, bytes);
  ++(taken ? counts.sent : counts.refused);
  if (taken) counts.sent_bytes += bytes.size();
  return taken;
}

bool DdsFleetLink::send(std::optional<VehicleId> to, Urgency urgency,
                        std::span<const std::uint8_t> bytes) {
  if (to) return sent_.count(*to) > 0 && send_one(*to, urgency, bytes);
  bool taken = true;
  if (urgency == Urgency::kBulk) {
    for (const FleetPeer& peer : options_.peers) {
      if (is_there(peer.id)) taken = send_one(peer.id, urgency, bytes) && taken;
    }
    return taken;
  }
  taken = write(kEveryone, urgency, bytes);
  for (auto& [id, counts] : sent_) {
    ++(taken ? counts.sent : counts.refused);
    if (taken) counts.sent_bytes += bytes.size();
  }
  return taken;
}

std::vector<LinkCounts> DdsFleetLink::counts() const {
  std::vector<LinkCounts> out;
  for (const auto& [id, counts] : sent_) {
    out.push_back(counts);
    inbox_.add_counts(out.back());
    out.back().matched = is_there(id);
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<FleetLink>> open_dds_fleet_link(const FleetLinkOptions& options) {
  if (const Status status = check(options); !status) return tl::make_unexpected(status.error());
  if (!sodium_is_ready()) {
    return fail(ErrorCode::kMachine, "libsodium", "has no random numbers of this machine");
  }
  auto link = std::make_unique<DdsFleetLink>(options);
  if (const Status status = link->open(); !status) return tl::make_unexpected(status.error());
  return link;
}

}  // namespace rali::net
