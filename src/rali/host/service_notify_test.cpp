#include "rali/host/service_notify.hpp"

#include <array>
#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace rali::host {
namespace {

TEST(ServiceNotify, sends_the_lines_to_the_service_manager) {
  const std::string path = testing::TempDir() + "notify.sock";
  unlink(path.c_str());
  const int listener = socket(AF_UNIX, SOCK_DGRAM, 0);
  ASSERT_GE(listener, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof(address.sun_path));
  std::memcpy(address.sun_path, path.c_str(), path.size());
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  notify_service("READY=1\nSTATUS=maps");
  std::array<char, 64> text{};
  const auto got = recv(listener, text.data(), text.size(), MSG_DONTWAIT);
  unsetenv("NOTIFY_SOCKET");
  close(listener);
  ASSERT_GT(got, 0);
  EXPECT_EQ(std::string(text.data(), static_cast<std::size_t>(got)), "READY=1\nSTATUS=maps");
}

TEST(ServiceNotify, does_nothing_without_a_service_manager) {
  unsetenv("NOTIFY_SOCKET");
  EXPECT_NO_THROW(notify_service("READY=1"));
}

}  // namespace
}  // namespace rali::host
