#include "fast_peer.hpp"

#include <cstring>
#include <functional>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

namespace rali::net {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kBytesMax = 4U << 20U;
constexpr std::uint32_t kSocketBytes = 4U << 20U;

/// Samples as bytes, encapsulation header included.
class RawType final : public dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kBytesMax;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);  // as in ROS 2's layer above Fast DDS
    auto_fill_type_information(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<const Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(payload->data, bytes.data(), bytes.size());
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }

  void* createData() override { return new Bytes; }

  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }

  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

dds::DomainParticipantQos loopback_qos() {
  dds::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  // A cloud comes in one burst; most of it would be dropped with the system's default.
  udp->receiveBufferSize = kSocketBytes;
  udp->sendBufferSize = kSocketBytes;
  qos.transport().listen_socket_buffer_size = kSocketBytes;
  qos.transport().send_socket_buffer_size = kSocketBytes;
  qos.transport().user_transports.push_back(udp);
  return qos;
}

}  // namespace

struct FastPeer::Parts {
  dds::DomainParticipant* participant = nullptr;
  dds::Topic* topic = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
  dds::DataWriter* writer = nullptr;
  dds::DataReader* reader = nullptr;
};

FastPeer::FastPeer(int domain, const std::string& topic, const std::string& type, bool is_reliable)
    : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.participant = dds::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<dds::DomainId_t>(domain), loopback_qos());
  if (p.participant == nullptr) return;
  dds::TypeSupport(new RawType(type)).register_type(p.participant);
  p.topic = p.participant->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  p.publisher = p.participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  p.subscriber = p.participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  if (p.topic == nullptr || p.publisher == nullptr || p.subscriber == nullptr) return;
  const auto reliability =
      is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  dds::DataWriterQos writer;
  writer.reliability().kind = reliability;
  writer.history().depth = 10;
  writer.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  writer.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;  // fragments
  dds::DataReaderQos reader;
  reader.reliability().kind = reliability;
  reader.history().depth = 10;
  reader.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  p.writer = p.publisher->create_datawriter(p.topic, writer);
  p.reader = p.subscriber->create_datareader(p.topic, reader);
}

FastPeer::~FastPeer() {
  if (parts_->participant == nullptr) return;
  (void)parts_->participant->delete_contained_entities();
  (void)dds::DomainParticipantFactory::get_instance()->delete_participant(parts_->participant);
}

bool FastPeer::is_open() const { return parts_->writer != nullptr && parts_->reader != nullptr; }

int FastPeer::matched_readers() const {
  dds::PublicationMatchedStatus status;
  (void)parts_->writer->get_publication_matched_status(status);
  return status.current_count;
}

int FastPeer::matched_writers() const {
  dds::SubscriptionMatchedStatus status;
  (void)parts_->reader->get_subscription_matched_status(status);
  return status.current_count;
}

bool FastPeer::write(const std::vector<std::uint8_t>& cdr) {
  Bytes bytes = cdr;
  return parts_->writer->write(&bytes);
}

std::vector<std::uint8_t> FastPeer::take() {
  Bytes bytes;
  dds::SampleInfo info;
  const auto code = parts_->reader->take_next_sample(&bytes, &info);
  return code == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK && info.valid_data ? bytes
                                                                                        : Bytes{};
}

}  // namespace rali::net
