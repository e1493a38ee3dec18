#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/cli/run_for_test.hpp"
#include "rali/view/view_server.hpp"

namespace rali::cli {
namespace {

/// A vehicle's view in this process.
class LiveCommands : public testing::Test {
 protected:
  void SetUp() override {
    view::ViewOptions options;
    options.port = 0;
    auto started = view::start_view_server(options);
    ASSERT_TRUE(started) << started.error().message();
    server = std::move(*started);
    url = fmt::format("http://127.0.0.1:{}", server->port());
    channel = server->add_channel({"/rali/state", "json", "rali/State", "jsonschema", "{}", true});
  }

  void publish(std::string_view state) {
    server->publish(channel, Time{1},
                    {reinterpret_cast<const std::uint8_t*>(state.data()), state.size()});
  }

  std::unique_ptr<view::ViewServer> server;
  std::string url;
  int channel = 0;
};

TEST_F(LiveCommands, status_prints_the_fleet) {
  publish(R"({"schema":1,"vehicle":"v1","vehicles":[{"name":"v1","mode":"explore"}]})");
  const Outcome run = run_rali({"status", url});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("v1       -     explore"), std::string::npos) << run.out;
}

TEST_F(LiveCommands, status_exits_with_1_while_the_anchor_is_lost) {
  publish(R"({"schema":1,"vehicle":"v1","anchor":{"lost":{"vehicle":"v2"}}})");
  const Outcome run = run_rali({"status", url});
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("ANCHOR LOST: v2"), std::string::npos) << run.out;
}

TEST_F(LiveCommands, status_prints_the_published_state_as_json) {
  const std::string state = R"({"schema":1,"vehicle":"v1"})";
  publish(state);
  EXPECT_EQ(run_rali({"status", url, "--json"}).out, state + '\n');
}

TEST_F(LiveCommands, status_reports_that_there_is_no_state_yet) {
  const Outcome run = run_rali({"status", url});
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.err, "rali: error: " + url + ": There is no state yet.\n");
}

TEST_F(LiveCommands, operator_sends_commands_to_the_vehicle) {
  EXPECT_EQ(run_rali({"operator", "assume-lost", "v2", url}).code, 0);
  EXPECT_EQ(run_rali({"operator", "end-round", url}).code, 0);
  const auto orders = server->take_requests();
  ASSERT_EQ(orders.size(), 2U);
  EXPECT_EQ(orders[0].command, "assume-lost");
  EXPECT_EQ(orders[0].vehicle, "v2");
  EXPECT_EQ(orders[1].command, "end-round");
}

TEST_F(LiveCommands, operator_refuses_invalid_commands) {
  const std::vector<std::vector<std::string>> wrong = {
      {"stop"}, {"assume-lost"}, {"assume-lost", url}, {"finish", url, "now"}, {}};
  for (const auto& words : wrong) {
    std::vector<std::string> all = {"operator"};
    all.insert(all.end(), words.begin(), words.end());
    const Outcome run = run_rali(all);
    EXPECT_EQ(run.code, 2) << run.err;
    EXPECT_EQ(run.err.substr(0, 12), "rali: error:") << run.err;
  }
  EXPECT_TRUE(server->take_requests().empty());
}

TEST_F(LiveCommands, an_address_without_a_vehicle_is_named_in_the_error) {
  server.reset();
  for (const char* command : {"status", "view"}) {
    const Outcome run = run_rali({command, url});
    EXPECT_EQ(run.code, 4);
    EXPECT_NE(run.err.find(url + ": no vehicle answers here"), std::string::npos) << run.err;
  }
}

TEST_F(LiveCommands, view_of_an_address_prints_the_url_of_the_vehicle) {
  publish(R"({"schema":1,"vehicle":"v1"})");
  const Outcome run = run_rali({"view", url});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, url + '\n');
}

TEST_F(LiveCommands, view_of_a_folder_without_results_asks_for_an_output_folder) {
  const Outcome run = run_rali({"view", RALI_SOURCE_DIR});
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.err.find("Give the output folder of rali map."), std::string::npos) << run.err;
}

}  // namespace
}  // namespace rali::cli
