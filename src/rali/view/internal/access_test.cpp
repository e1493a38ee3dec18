#include "rali/view/internal/access.hpp"

#include <gtest/gtest.h>

#include "rali/view/internal/answers.hpp"

namespace rali::view {
namespace {

constexpr std::string_view kToken = "0123456789abcdef";

AccessRequest local() { return {.from_loopback = true, .target = "/", .host = "127.0.0.1:8765"}; }

TEST(Access, loopback_needs_no_token) {
  EXPECT_EQ(access_of(local(), ""), Access::kGranted);
  for (const char* host : {"localhost", "localhost:8765", "127.0.0.3:8767", "[::1]:8765", ""}) {
    AccessRequest request = local();
    request.host = host;
    EXPECT_EQ(access_of(request, kToken), Access::kGranted) << host;
  }
}

TEST(Access, another_machine_needs_the_token_in_header_or_url) {
  AccessRequest far{.target = "/", .host = "10.0.0.2:8765"};
  EXPECT_EQ(access_of(far, kToken), Access::kNoToken);
  EXPECT_EQ(access_of(far, ""), Access::kNoToken) << "no token opens nothing";
  far.authorization = "Bearer 0123456789abcdef";
  EXPECT_EQ(access_of(far, kToken), Access::kGranted);
  far.authorization = "Bearer 0123456789abcdeg";
  EXPECT_EQ(access_of(far, kToken), Access::kNoToken);
  far.authorization = "Basic 0123456789abcdef";
  EXPECT_EQ(access_of(far, kToken), Access::kNoToken);
  far.authorization = "";
  for (const char* target : {"/?token=0123456789abcdef", "/ws?a=b&token=0123456789abcdef&c"}) {
    far.target = target;
    EXPECT_EQ(access_of(far, kToken), Access::kGranted) << target;
  }
  for (const char* target : {"/?token=", "/?token", "/?", "/?token=0123456789abcdef0", "/token=x",
                             "/?xtoken=0123456789abcdef"}) {
    far.target = target;
    EXPECT_EQ(access_of(far, kToken), Access::kNoToken) << target;
  }
}

TEST(Access, foreign_host_names_resolving_to_loopback_are_refused) {
  for (const char* host : {"evil.org", "127.evil.org:8765", "localhost.evil.org", "10.0.0.2"}) {
    AccessRequest request = local();
    request.host = host;
    EXPECT_EQ(access_of(request, ""), Access::kForeignHost) << host;
  }
}

TEST(Access, requests_from_pages_of_other_origins_are_refused) {
  AccessRequest request = local();
  request.origin = "http://127.0.0.1:8765";
  EXPECT_EQ(access_of(request, ""), Access::kGranted);
  for (const char* origin : {"http://evil.org", "null", "https://127.0.0.1:8765",
                             "http://127.0.0.1:9999", "https://app.foxglove.dev"}) {
    request.origin = origin;
    EXPECT_EQ(access_of(request, ""), Access::kForeignPage) << origin;
  }
}

TEST(Access, foxglove_origin_is_accepted_for_websockets) {
  AccessRequest request = local();
  request.origin = "https://app.foxglove.dev";
  request.websocket = true;
  EXPECT_EQ(access_of(request, ""), Access::kGranted);
  request.origin = "https://evil.org";
  EXPECT_EQ(access_of(request, ""), Access::kForeignPage);
}

HttpAnswer ask(Published& published, std::string_view method, std::string_view path,
               std::string_view body = "", std::string_view type = "application/json") {
  return answer({method, path, type, body}, published);
}

TEST(Answers, health_is_503_until_the_host_reports_it) {
  Published p;
  EXPECT_EQ(ask(p, "GET", "/healthz").status, 503);
  p.healthy = true;
  p.health = R"({"state":"ok"})";
  EXPECT_EQ(ask(p, "GET", "/healthz").status, 200);
  EXPECT_EQ(*ask(p, "GET", "/healthz").body, p.health);
}

TEST(Answers, metrics_include_those_of_host_and_view) {
  Published p;
  p.metrics = "rali_term 4\n";
  p.viewers = 2;
  const std::string body = *ask(p, "GET", "/metrics").body;
  EXPECT_EQ(body.substr(0, 12), "rali_term 4\n");
  EXPECT_NE(body.find("rali_view_viewers 2\n"), std::string::npos);
}

TEST(Answers, state_is_the_last_published_one_or_503) {
  Published p;
  EXPECT_EQ(ask(p, "GET", "/state").status, 503);
  p.state = "{}";
  EXPECT_EQ(*ask(p, "GET", "/state").body, "{}");
}

TEST(Answers, unknown_path_is_404_and_unsupported_method_is_405) {
  Published p;
  EXPECT_EQ(ask(p, "GET", "/../etc/passwd").status, 404);
  EXPECT_EQ(ask(p, "PUT", "/state").status, 405);
  EXPECT_EQ(ask(p, "GET", "/operator").allow, "POST");
}

TEST(Answers, operator_commands_are_queued_for_the_host) {
  Published p;
  EXPECT_EQ(ask(p, "POST", "/operator", R"({"command":"end-round"})").status, 202);
  EXPECT_EQ(ask(p, "POST", "/operator", R"({"command":"assume-lost","vehicle":"v2"})").status, 202);
  ASSERT_EQ(p.orders.size(), 2U);
  EXPECT_EQ(p.orders[1].vehicle, "v2");
}

TEST(Answers, invalid_operator_commands_are_refused_and_not_queued) {
  Published p;
  for (const char* body :
       {"", "[]", R"({"command":"stop"})", R"({"command":7})", R"({"command":"assume-lost"})",
        R"({"command":"assume-lost","vehicle":""})",
        R"({"command":"assume-lost","vehicle":"a b"})"}) {
    EXPECT_EQ(ask(p, "POST", "/operator", body).status, 400) << body;
  }
  EXPECT_EQ(ask(p, "POST", "/operator", R"({"command":"finish"})", "text/plain").status, 415);
  EXPECT_TRUE(p.orders.empty());
}

TEST(Answers, the_operator_command_queue_is_limited) {
  Published p;
  for (std::size_t i = 0; i < kOrdersMax; ++i) {
    EXPECT_EQ(ask(p, "POST", "/operator", R"({"command":"finish"})").status, 202);
  }
  EXPECT_EQ(ask(p, "POST", "/operator", R"({"command":"finish"})").status, 503);
}

TEST(Answers, page_contains_its_style_and_script_and_loads_nothing) {
  Published p;
  const std::string page = *ask(p, "GET", "/").body;
  EXPECT_EQ(page.find("/*STYLE*/"), std::string::npos);
  EXPECT_EQ(page.find("/*SCRIPT*/"), std::string::npos);
  EXPECT_NE(page.find("<title>RaLI</title>"), std::string::npos);
  EXPECT_EQ(page.find("<script src"), std::string::npos);
  EXPECT_EQ(page.find("<link rel=\"stylesheet"), std::string::npos);
}

}  // namespace
}  // namespace rali::view
