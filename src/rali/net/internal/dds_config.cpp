#include "rali/net/internal/dds_config.hpp"

#include <algorithm>
#include <set>

#include <arpa/inet.h>
#include <fmt/format.h>

#include "rali/net/envelope.hpp"
#include "rali/net/ros_names.hpp"

namespace rali::net {
namespace {

constexpr int kDomainMax = 232;        // RTPS 9.6.1.1: above it ports do not fit into 16 bits
constexpr int kDomainMaxShared = 229;  // with up to 100 participants on one machine
constexpr std::uint32_t kLoopbackNet = 127U << 24U;
constexpr std::uint32_t kLoopbackHosts = 100;
constexpr int kPortBase = 7400, kDomainGain = 250, kParticipantGain = 2, kDiscoveryOffset = 10;

/// n of 127.0.0.n, 1 to 100; 0 for other addresses.
std::uint32_t loopback_host(std::uint32_t address) {
  const std::uint32_t host = address - kLoopbackNet;
  return address > kLoopbackNet && host <= kLoopbackHosts ? host : 0;
}

bool is_plain(const std::string& text) {
  return !text.empty() && text.size() < 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_' || c == ':' || c == '@';
  });
}

std::string with_extra(std::string config, const std::string& extra) {
  if (!extra.empty()) config += "," + extra;
  return config;
}

}  // namespace

std::optional<std::uint32_t> parse_ipv4(const std::string& text) {
  in_addr address{};
  if (::inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
  const std::uint32_t value = ntohl(address.s_addr);
  const bool is_host = value != 0 && value >> 28U != 14U && value != 0xFFFFFFFFU;  // 224/4:
                                                                                   // multicast
  return is_host ? std::optional(value) : std::nullopt;
}

Status check(const RosBusOptions& options) {
  if (options.domain < 0 || options.domain > kDomainMax) {
    return fail(ErrorCode::kUsage, "domain", fmt::format("{} is no domain of ROS", options.domain),
                "Set ROS_DOMAIN_ID to 0 to 232.");
  }
  if (!is_plain(options.interface)) {
    return fail(ErrorCode::kUsage, options.interface, "is no name of a network interface",
                "`ip address` lists them; lo is this machine alone.");
  }
  if (options.gid_bytes != 16 && options.gid_bytes != 24) {
    return fail(ErrorCode::kUsage, "gid_bytes", "is neither 16 nor 24",
                "Set 24 for ROS 2 Humble and older, 16 for what came later.");
  }
  const std::string space = options.node_namespace == "/" ? "" : options.node_namespace;
  if (!dds_topic_name(space + "/" + options.node_name)) {
    return fail(ErrorCode::kUsage, options.node_namespace + " " + options.node_name,
                "is no name of a node of ROS", "Use letters, digits and underscores.");
  }
  return {};
}

Status check(const FleetLinkOptions& options) {
  if (options.domain < 0 || options.domain > kDomainMaxShared) {
    return fail(ErrorCode::kUsage, "domain", fmt::format("{} is no domain", options.domain),
                "Set 0 to 229, another one than ROS_DOMAIN_ID.");
  }
  std::set<std::uint16_t> numbers;
  std::set<std::uint32_t> addresses;
  std::vector<FleetPeer> all = options.peers;
  all.push_back({options.self, options.address, 0});
  bool self_local = false, one_local = false, one_remote = false;
  for (const FleetPeer& vehicle : all) {
    const auto address = parse_ipv4(vehicle.address);
    if (!address) {
      return fail(ErrorCode::kUsage, fmt::format("vehicle {}", vehicle.id.value),
                  fmt::format("\"{}\" is no IPv4 address", vehicle.address),
                  "Give the address of the vehicle in the fleet's network.");
    }
    self_local = loopback_host(*address) != 0;
    (*address >> 24U == 127U ? one_local : one_remote) = true;
    if (*address >> 24U == 127U && !self_local) {
      return fail(ErrorCode::kUsage, vehicle.address, "is outside 127.0.0.1 to 127.0.0.100",
                  "Vehicles on one machine are 127.0.0.1, 127.0.0.2 and so on.");
    }
    if (vehicle.id.value == kEveryone || !numbers.insert(vehicle.id.value).second ||
        !addresses.insert(*address).second) {
      return fail(ErrorCode::kUsage, vehicle.address,
                  fmt::format("vehicle {} or its address stands there twice", vehicle.id.value),
                  "Each vehicle has its own number below 65535 and its own address.");
    }
  }
  if (one_local && one_remote) {
    return fail(ErrorCode::kUsage, options.address, "a fleet is on one machine or on a network",
                "Give all vehicles 127.0.0.n, or none.");
  }
  return {};
}

std::string cyclone_config(const RosBusOptions& options) {
  const bool is_loopback = options.interface == "lo" || options.interface.starts_with("127.");
  const bool is_address = parse_ipv4(options.interface).has_value();
  // Loopback has no multicast: participants discover each other port by port, as rmw_cyclonedds
  // does with ROS_LOCALHOST_ONLY.
  const std::string found_by = is_loopback
                                   ? "<AllowMulticast>false</AllowMulticast></General><Discovery>"
                                     "<ParticipantIndex>auto</ParticipantIndex>"
                                     "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
                                     "<SPDPInterval>1s</SPDPInterval>"
                                     "<Peers><Peer address=\"127.0.0.1\"/></Peers>"
                                   : std::string("</General><Discovery>");
  // The watermark is above several clouds; otherwise a second one is refused while the first is in
  // transit to a reliable reader.
  return with_extra(
      fmt::format("<CycloneDDS><Domain><General><Interfaces><NetworkInterface {}=\"{}\"/>"
                  "</Interfaces>{}<ExternalDomainId>{}</ExternalDomainId></Discovery>"
                  "<Internal><MaxSampleSize>{}B</MaxSampleSize>"
                  "<SocketReceiveBufferSize max=\"8MB\"/>"
                  "<Watermarks><WhcHigh>16MB</WhcHigh><WhcAdaptive>false</WhcAdaptive>"
                  "</Watermarks></Internal></Domain></CycloneDDS>",
                  is_address ? "address" : "name", options.interface, found_by, options.domain,
                  2 * options.message_bytes_max),
      options.cyclone_config);
}

std::string cyclone_config(const FleetLinkOptions& options) {
  const std::uint32_t own = parse_ipv4(options.address).value_or(0);
  const std::uint32_t index = loopback_host(own) == 0 ? 0 : loopback_host(own) - 1;
  std::string peers;
  for (const FleetPeer& peer : options.peers) {
    const std::uint32_t host = loopback_host(parse_ipv4(peer.address).value_or(0));
    if (host == 0) {
      peers += fmt::format("<Peer address=\"{}\"/>", peer.address);
    } else {
      const int port = kPortBase + kDomainGain * options.domain + kDiscoveryOffset +
                       kParticipantGain * static_cast<int>(host - 1);
      peers += fmt::format("<Peer address=\"127.0.0.1:{}\"/>", port);
    }
  }
  // Datagrams fit into WireGuard's 1420 bytes; timers for radio links (middleware 3.2). With more
  // in transit than the line carries within NackDelay, readers request again what is on its way,
  // and repetitions fill the line: 64 kB are 100 ms of 5 Mbit/s.
  return with_extra(
      fmt::format(
          "<CycloneDDS><Domain><General><Interfaces>"
          "<NetworkInterface address=\"{}\" multicast=\"false\"/></Interfaces>"
          "<AllowMulticast>false</AllowMulticast><MaxMessageSize>1300B</MaxMessageSize>"
          "<FragmentSize>1200B</FragmentSize></General>"
          "<Discovery><ExternalDomainId>{}</ExternalDomainId>"
          "<ParticipantIndex>{}</ParticipantIndex>"
          "<MaxAutoParticipantIndex>0</MaxAutoParticipantIndex><SPDPInterval>1s</SPDPInterval>"
          "<LeaseDuration>8s</LeaseDuration><Peers>{}</Peers></Discovery>"
          "<Internal><NackDelay>60ms</NackDelay><AutoReschedNackDelay>60ms</AutoReschedNackDelay>"
          "<Watermarks><WhcHigh>64kB</WhcHigh></Watermarks>"
          "<HeartbeatInterval min=\"10ms\" minsched=\"20ms\" max=\"200ms\">50ms"
          "</HeartbeatInterval><MaxSampleSize>{}B</MaxSampleSize></Internal>"
          "</Domain></CycloneDDS>",
          index == 0 && loopback_host(own) == 0 ? options.address : "127.0.0.1", options.domain,
          index, peers, 2 * (options.message_bytes_max + kEnvelopeBytes)),
      options.cyclone_config);
}

}  // namespace rali::net
