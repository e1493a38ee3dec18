#include "rali/net/serial_port.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "rali/net/wall_clock.hpp"

namespace rali::net {
namespace {

constexpr std::size_t kReadBytesMax = 4096;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kTimeoutMsMax = 60'000;

std::optional<speed_t> speed_of(int baud) {
  constexpr std::array<std::pair<int, speed_t>, 8> kSpeeds{{{115200, B115200},
                                                            {230400, B230400},
                                                            {460800, B460800},
                                                            {921600, B921600},
                                                            {1000000, B1000000},
                                                            {1500000, B1500000},
                                                            {2000000, B2000000},
                                                            {3000000, B3000000}}};
  for (const auto& [number, speed] : kSpeeds) {
    if (number == baud) return speed;
  }
  return std::nullopt;
}

tl::unexpected<Error> port_fault(const std::string& path, const char* what, int number) {
  const char* remedy = "";
  if (number == EACCES) remedy = "Add the user to the group dialout.";
  if (number == ENOENT) remedy = "Look at /dev/serial/by-id for what is plugged in.";
  return fail(ErrorCode::kMachine, path, std::string(what) + ": " + std::strerror(number), remedy);
}

}  // namespace

Result<SerialPort> SerialPort::open(const std::string& path, int baud) {
  const auto speed = speed_of(baud);
  if (!speed) {
    return fail(ErrorCode::kUsage, path, "has no speed of " + std::to_string(baud) + " Bd",
                "Set 115200, 230400, 460800, 921600, 1000000, 1500000, 2000000 or 3000000.");
  }
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return port_fault(path, "cannot be opened", errno);
  SerialPort port(descriptor, path);
  termios mode{};
  if (::tcgetattr(descriptor, &mode) != 0) return port_fault(path, "is no serial port", errno);
  ::cfmakeraw(&mode);
  mode.c_cflag |= CLOCAL | CREAD;
  mode.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  mode.c_cc[VMIN] = 1;
  mode.c_cc[VTIME] = 0;
  if (::cfsetispeed(&mode, *speed) != 0 || ::cfsetospeed(&mode, *speed) != 0 ||
      ::tcsetattr(descriptor, TCSANOW, &mode) != 0) {
    return port_fault(path, "cannot be set", errno);
  }
  ::tcflush(descriptor, TCIFLUSH);  // discards bytes received at another speed
  return port;
}

SerialPort::SerialPort(SerialPort&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

SerialPort& SerialPort::operator=(SerialPort&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

SerialPort::~SerialPort() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<SerialBytes> SerialPort::read(Duration timeout) {
  SerialBytes out;
  pollfd wait{descriptor_, POLLIN, 0};
  const auto ms = std::clamp<std::int64_t>(timeout.ns / kNsPerMs, 0, kTimeoutMsMax);
  const int ready = ::poll(&wait, 1, static_cast<int>(ms));
  if (ready < 0 && errno != EINTR) return port_fault(path_, "cannot be waited for", errno);
  out.t = wall_now();
  if (ready <= 0) return out;
  out.bytes.resize(kReadBytesMax);
  const ssize_t n = ::read(descriptor_, out.bytes.data(), out.bytes.size());
  if (n < 0 && errno != EAGAIN && errno != EINTR) return port_fault(path_, "is gone", errno);
  // An unplugged device is always ready and has no bytes.
  if (n == 0 || (n < 0 && (wait.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0)) {
    return port_fault(path_, "is gone", ENODEV);
  }
  out.bytes.resize(n < 0 ? 0 : static_cast<std::size_t>(n));
  return out;
}

}  // namespace rali::net
