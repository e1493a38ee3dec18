#include "rali/view/view_client.hpp"

#include <gtest/gtest.h>

#include "rali/view/view_server.hpp"

namespace rali::view {
namespace {

TEST(ViewAddress, is_parsed_with_and_without_optional_parts) {
  struct Case {
    const char *url, *host;
    int port;
    const char* token;
  };

  for (const Case& c :
       {Case{"http://127.0.0.1:8766", "127.0.0.1", 8766, ""}, Case{"robot", "robot", 8765, ""},
        Case{"robot:81/", "robot", 81, ""}, Case{"http://[::1]:8765/", "::1", 8765, ""},
        Case{"[::1]", "::1", 8765, ""}, Case{"http://r:8765/?token=abc", "r", 8765, "abc"}}) {
    const auto address = parse_view_address(c.url);
    ASSERT_TRUE(address) << c.url << address.error().message();
    EXPECT_EQ(address->host, c.host);
    EXPECT_EQ(address->port, c.port);
    EXPECT_EQ(address->token, c.token);
  }
}

TEST(ViewAddress, that_is_invalid_is_refused) {
  for (const char* url : {"", "http://", "https://robot", "robot:0", "robot:99999", "robot:x",
                          "a b", "robot/x", "user@robot", "robot?x=1"}) {
    const auto address = parse_view_address(url);
    ASSERT_FALSE(address) << url;
    EXPECT_EQ(address.error().code, ErrorCode::kUsage);
  }
}

TEST(ViewClient, sends_queries_and_operator_commands) {
  ViewOptions options;
  options.port = 0;
  const auto server = start_view_server(options);
  ASSERT_TRUE(server);
  ViewAddress address;
  address.port = (*server)->port();
  const auto health = ask_view(address, "/healthz");
  ASSERT_TRUE(health) << health.error().message();
  EXPECT_EQ(health->status, 503U);
  const auto order = ask_view(address, "/operator", R"({"command":"finish"})");
  ASSERT_TRUE(order);
  EXPECT_EQ(order->status, 202U);
  EXPECT_EQ((*server)->take_requests().size(), 1U);
}

TEST(ViewClient, names_the_address_that_does_not_answer) {
  ViewAddress address;
  address.port = 1;
  const auto reply = ask_view(address, "/state");
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::kMachine);
  EXPECT_NE(reply.error().message().find("http://127.0.0.1:1: no vehicle answers here"),
            std::string::npos);
}

}  // namespace
}  // namespace rali::view
