#include "emulated_radio.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace rali::net {
namespace {

constexpr const char* kInterface = "radio0";
constexpr int kMtu = 1500;
constexpr std::size_t kFrameBytesMax = 2048;
constexpr std::size_t kEthernetHeader = 14;
constexpr int kPollMsMax = 20;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Socket {
 public:
  Socket() : number_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}

  ~Socket() {
    if (number_ >= 0) ::close(number_);
  }

  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  [[nodiscard]] bool ask(unsigned long request, ifreq& about) const {
    return ::ioctl(number_, request, &about) == 0;
  }

 private:
  int number_;
};

ifreq request_about(const char* interface) {
  ifreq request{};
  std::strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  return request;
}

void put_address(sockaddr& out, const std::string& text) {
  auto* address = reinterpret_cast<sockaddr_in*>(&out);
  address->sin_family = AF_INET;
  ::inet_pton(AF_INET, text.c_str(), &address->sin_addr);
}

bool bring_up(const Socket& socket, const char* interface) {
  ifreq request = request_about(interface);
  if (!socket.ask(SIOCGIFFLAGS, request)) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  return socket.ask(SIOCSIFFLAGS, request);
}

/// Acts in the namespace of the calling thread. The last byte of the hardware address is the
/// vehicle.
bool configure(std::size_t vehicle) {
  const Socket socket;
  ifreq hardware = request_about(kInterface);
  hardware.ifr_hwaddr.sa_family = ARPHRD_ETHER;
  hardware.ifr_hwaddr.sa_data[0] = 2;
  hardware.ifr_hwaddr.sa_data[5] = static_cast<char>(vehicle);
  ifreq address = request_about(kInterface), mask = request_about(kInterface),
        mtu = request_about(kInterface);
  put_address(address.ifr_addr, EmulatedRadio::address(vehicle));
  put_address(mask.ifr_netmask, "255.255.255.0");
  mtu.ifr_mtu = kMtu;
  return socket.ask(SIOCSIFHWADDR, hardware) && socket.ask(SIOCSIFADDR, address) &&
         socket.ask(SIOCSIFNETMASK, mask) && socket.ask(SIOCSIFMTU, mtu) &&
         bring_up(socket, kInterface) && bring_up(socket, "lo");
}

int open_tap() {
  const int tap = ::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (tap < 0) return -1;
  ifreq request = request_about(kInterface);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (::ioctl(tap, TUNSETIFF, &request) == 0) return tap;
  ::close(tap);
  return -1;
}

bool is_arp(const std::vector<std::uint8_t>& frame) {
  return frame.size() > kEthernetHeader && frame[12] == 0x08 && frame[13] == 0x06;
}

}  // namespace

EmulatedRadio::EmulatedRadio(std::size_t vehicles)
    : ports_(vehicles), links_(vehicles * vehicles), rng_(1, "radio") {}

EmulatedRadio::~EmulatedRadio() {
  thread_ = {};  // stops and joins
  for (const Port& port : ports_) {
    if (port.tap >= 0) ::close(port.tap);
    if (port.space >= 0) ::close(port.space);
  }
}

std::unique_ptr<EmulatedRadio> EmulatedRadio::create(std::size_t vehicles, std::string& why_not) {
  std::unique_ptr<EmulatedRadio> radio(new EmulatedRadio(vehicles));
  for (std::size_t i = 0; i < vehicles; ++i) {
    if (!radio->add_port(i, why_not)) return nullptr;
  }
  return radio;
}

bool EmulatedRadio::add_port(std::size_t vehicle, std::string& why_not) {
  Port& port = ports_[vehicle];
  // A separate thread enters the new namespace, so that the caller stays in its own.
  std::thread([&] {
    if (::unshare(CLONE_NEWNET) != 0) {
      why_not = std::string("no network namespace (root?): ") + std::strerror(errno);
      return;
    }
    port.space = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    port.tap = open_tap();
    if (port.tap < 0) {
      why_not = std::string("no /dev/net/tun: ") + std::strerror(errno);
    } else if (port.space < 0 || !configure(vehicle)) {
      why_not = std::string("no interface: ") + std::strerror(errno);
    }
  }).join();
  return why_not.empty();
}

std::string EmulatedRadio::space(std::size_t vehicle) const {
  return "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(ports_[vehicle].space);
}

bool EmulatedRadio::enter(std::size_t vehicle) const {
  return ::setns(ports_[vehicle].space, CLONE_NEWNET) == 0;
}

void EmulatedRadio::set_all(const LinkModel& model) {
  const std::lock_guard lock(mutex_);
  for (Link& one : links_) one.model = model;
}

void EmulatedRadio::set(std::size_t from, std::size_t to, const LinkModel& model) {
  const std::lock_guard lock(mutex_);
  link(from, to).model = model;
}

EmulatedRadio::Traffic EmulatedRadio::traffic(std::size_t from, std::size_t to) const {
  const std::lock_guard lock(mutex_);
  return links_[from * ports_.size() + to].traffic;
}

void EmulatedRadio::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void EmulatedRadio::run(const std::stop_token& stop) {
  std::vector<pollfd> waits;
  for (const Port& port : ports_) waits.push_back({port.tap, POLLIN, 0});
  while (!stop.stop_requested()) {
    int timeout_ms = kPollMsMax;
    {
      const std::lock_guard lock(mutex_);
      if (!frames_.empty()) {
        const double wait_ms = std::ceil(1e3 * (frames_.top().due_s - now_s()));
        timeout_ms = static_cast<int>(std::clamp(wait_ms, 0.0, double{kPollMsMax}));
      }
    }
    (void)::poll(waits.data(), waits.size(), timeout_ms);
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      if ((waits[i].revents & POLLIN) != 0) read_port(i);
    }
    deliver_due();
  }
}

void EmulatedRadio::read_port(std::size_t from) {
  std::vector<std::uint8_t> frame(kFrameBytesMax);
  for (;;) {
    const ssize_t n = ::read(ports_[from].tap, frame.data(), frame.size());
    if (n < static_cast<ssize_t>(kEthernetHeader)) return;
    const std::vector<std::uint8_t> bytes(frame.begin(), frame.begin() + n);
    const bool to_all = (bytes[0] & 1U) != 0;
    for (std::size_t to = 0; to < ports_.size(); ++to) {
      if (to != from && (to_all || bytes[5] == to)) forward(from, to, bytes);
    }
  }
}

void EmulatedRadio::forward(std::size_t from, std::size_t to,
                            const std::vector<std::uint8_t>& bytes) {
  Link& path = link(from, to);
  ++path.traffic.frames_in;
  const LinkModel& model = path.model;
  if (model.cut || (!is_arp(bytes) && rng_.uniform() < model.loss)) return;
  const double t_s = now_s();
  double sent_s = t_s;
  if (model.bytes_per_s > 0.0) {
    const double waiting = std::max(0.0, path.free_s - t_s) * model.bytes_per_s;
    if (waiting > static_cast<double>(model.queue_bytes)) return;
    path.free_s =
        std::max(path.free_s, t_s) + static_cast<double>(bytes.size()) / model.bytes_per_s;
    sent_s = path.free_s;
  }
  const double due_s = sent_s + model.delay_s + rng_.uniform(0.0, model.jitter_s);
  frames_.push({due_s, order_++, from, to, bytes});
}

void EmulatedRadio::deliver_due() {
  const double t_s = now_s();
  while (!frames_.empty() && frames_.top().due_s <= t_s) {
    const Frame& frame = frames_.top();
    if (::write(ports_[frame.to].tap, frame.bytes.data(), frame.bytes.size()) > 0) {
      Traffic& traffic = link(frame.from, frame.to).traffic;
      ++traffic.frames_out;
      traffic.bytes_out += frame.bytes.size();
    }
    frames_.pop();
  }
}

}  // namespace rali::net
