#include "rali/net/serial_port.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include "rali/base/test_folder.hpp"
#include "rali/net/wall_clock.hpp"
#include "rali/wire/linktrack_serial.hpp"

namespace rali::net {
namespace {

const Duration kSecond = Duration::from_s(1.0);

/// A pseudo terminal: bytes written to `device` are read by a SerialPort at `name`.
class PseudoTerminal {
 public:
  PseudoTerminal() {
    std::array<char, 128> name{};
    int port = -1;
    if (::openpty(&device_, &port, name.data(), nullptr, nullptr) == 0) name_ = name.data();
    port_ = port;
  }

  ~PseudoTerminal() {
    close_device();
    if (port_ >= 0) ::close(port_);
  }

  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

  void write(const std::vector<std::uint8_t>& bytes) const {
    ASSERT_EQ(::write(device_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }

  void close_device() {
    if (device_ >= 0) ::close(device_);
    device_ = -1;
  }

 private:
  int device_ = -1, port_ = -1;
  std::string name_;
};

/// LinkTrack Nodeframe3 of radio 4 with one range to radio 5 (middleware 6).
std::vector<std::uint8_t> nodeframe3(std::uint32_t range_mm) {
  std::vector<std::uint8_t> out(21 + 7 + 1);
  out[0] = 0x55;
  out[1] = 0x05;
  out[2] = static_cast<std::uint8_t>(out.size());
  out[4] = 2;   // role
  out[5] = 4;   // id
  out[20] = 1;  // nodes
  out[21] = 2;
  out[22] = 5;
  for (std::size_t i = 0; i < 3; ++i) {
    out[23 + i] = static_cast<std::uint8_t>((range_mm >> (8 * i)) & 0xFFU);
  }
  out[26] = 160;  // -80 dBm
  out[27] = 162;
  out.back() = static_cast<std::uint8_t>(std::accumulate(out.begin(), out.end() - 1, 0) & 0xFF);
  return out;
}

class SerialPorts : public ::testing::Test {
 protected:
  void SetUp() override {
    if (terminal_.name().empty()) GTEST_SKIP() << "no pseudo terminal on this machine";
  }

  PseudoTerminal terminal_;
};

TEST_F(SerialPorts, every_byte_value_is_received_unchanged) {
  auto port = SerialPort::open(terminal_.name());
  ASSERT_TRUE(port) << port.error().message();
  std::vector<std::uint8_t> all(256);
  std::iota(all.begin(), all.end(), std::uint8_t{0});  // control characters and newlines too
  const Time before = wall_now();
  terminal_.write(all);
  std::vector<std::byte> got;
  while (got.size() < all.size()) {
    const auto bytes = port->read(kSecond);
    ASSERT_TRUE(bytes) << bytes.error().message();
    ASSERT_FALSE(bytes->bytes.empty());
    EXPECT_GE(bytes->t, before);
    EXPECT_LE(bytes->t, wall_now());
    got.insert(got.end(), bytes->bytes.begin(), bytes->bytes.end());
  }
  EXPECT_TRUE(std::equal(all.begin(), all.end(), got.begin(), got.end(),
                         [](std::uint8_t a, std::byte b) { return std::byte{a} == b; }));
}

TEST_F(SerialPorts, linktrack_frames_are_received_after_noise_and_in_fragments) {
  auto port = SerialPort::open(terminal_.name());
  ASSERT_TRUE(port) << port.error().message();
  wire::LinktrackStream stream;
  std::vector<double> ranges_m;
  std::vector<std::uint8_t> sent{0x55, 0x05, 0xFF, 0x11, 0x13, 0x0D, 0x0A};
  for (std::uint32_t i = 1; i <= 3; ++i) {
    const auto frame = nodeframe3(1000 * i);
    sent.insert(sent.end(), frame.begin(), frame.end());
  }
  for (std::size_t at = 0; at < sent.size(); at += 10) {
    const std::size_t n = std::min<std::size_t>(10, sent.size() - at);
    const auto first = sent.begin() + static_cast<std::ptrdiff_t>(at);
    terminal_.write({first, first + static_cast<std::ptrdiff_t>(n)});
    const auto bytes = port->read(kSecond);
    ASSERT_TRUE(bytes) << bytes.error().message();
    stream.push(bytes->bytes);
    while (const auto frame = stream.next()) {
      EXPECT_EQ(frame->id, 4U);
      ASSERT_EQ(frame->nodes.size(), 1U);
      EXPECT_EQ(frame->nodes[0].id, 5U);
      ranges_m.push_back(frame->nodes[0].range_m);
    }
  }
  while (const auto frame = stream.next(true)) ranges_m.push_back(frame->nodes.at(0).range_m);
  EXPECT_EQ(ranges_m, (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST_F(SerialPorts, reading_ends_with_the_timeout) {
  auto port = SerialPort::open(terminal_.name());
  ASSERT_TRUE(port) << port.error().message();
  const auto nothing = port->read(Duration::from_s(0.02));
  ASSERT_TRUE(nothing) << nothing.error().message();
  EXPECT_TRUE(nothing->bytes.empty());
}

TEST_F(SerialPorts, a_disconnected_device_is_an_error) {
  auto port = SerialPort::open(terminal_.name());
  ASSERT_TRUE(port) << port.error().message();
  terminal_.close_device();
  const auto gone = port->read(kSecond);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, ErrorCode::kMachine);
}

TEST_F(SerialPorts, port_is_set_to_its_baud_rate_and_raw_mode) {
  const auto port = SerialPort::open(terminal_.name(), 460800);
  ASSERT_TRUE(port) << port.error().message();
  const int descriptor = ::open(terminal_.name().c_str(), O_RDONLY | O_NOCTTY);
  termios mode{};
  ASSERT_EQ(::tcgetattr(descriptor, &mode), 0);
  ::close(descriptor);
  EXPECT_EQ(::cfgetispeed(&mode), static_cast<speed_t>(B460800));
  EXPECT_EQ(mode.c_lflag & static_cast<tcflag_t>(ICANON | ECHO | ISIG), 0U);
  EXPECT_EQ(mode.c_iflag & static_cast<tcflag_t>(ICRNL | IXON), 0U);
}

TEST(SerialPort, unusable_device_or_baud_rate_is_an_error) {
  const TestFolder folder;
  EXPECT_EQ(SerialPort::open(folder.path("none")).error().code, ErrorCode::kMachine);
  EXPECT_EQ(SerialPort::open("/dev/null").error().code, ErrorCode::kMachine);
  EXPECT_EQ(SerialPort::open("/dev/null", 12345).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace rali::net
