#include "rali/view/internal/foxglove.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/view/internal/viewer_channels.hpp"

namespace rali::view {
namespace {

TEST(Foxglove, selects_the_first_supported_subprotocol_of_the_client) {
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_subprotocol("mqtt , foxglove.sdk.v1,foxglove.websocket.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(choose_subprotocol(""), "");
  EXPECT_EQ(choose_subprotocol(",, ,"), "");
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v10"), "");
}

TEST(Foxglove, parses_subscribe_and_unsubscribe) {
  const auto begun = parse_client_message(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":8,"channelId":3}]})");
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->subscribe, (std::vector<Subscription>{{7, 2}, {8, 3}}));
  const auto ended = parse_client_message(R"({"op":"unsubscribe","subscriptionIds":[7]})");
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->unsubscribe, std::vector<std::uint32_t>{7});
}

TEST(Foxglove, refuses_invalid_client_messages_with_a_reason) {
  for (const char* text :
       {"", "x", "[]", "7", "{}", R"({"op":1})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":{}})", R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":2}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":2}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":2}]})",
        R"({"op":"unsubscribe","subscriptionIds":["a"]})", "\xFF\xFE"}) {
    const auto parsed = parse_client_message(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_NE(parsed.error().message().find("message of a viewer: "), std::string::npos) << text;
  }
  EXPECT_FALSE(parse_client_message(std::string(kClientMessageBytesMax + 1, ' ')));
  EXPECT_FALSE(parse_client_message(std::string(60000, '[')));
}

TEST(Foxglove, names_operations_that_a_read_only_server_does_not_support) {
  const auto parsed = parse_client_message(R"({"op":"setParameters","parameters":[]})");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->unsupported, "setParameters");
}

TEST(Foxglove, frame_header_has_the_expected_bytes) {
  EXPECT_EQ(data_header(0x01020304, Time{0x1112131415161718}),
            (DataHeader{0x01, 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11}));
}

TEST(Foxglove, advertises_topics_with_invalid_utf8_names) {
  const std::vector<NumberedChannel> channels = {
      {3, {"/\xFF", "cdr", "sensor_msgs/msg/PointCloud2", "ros2msg", "uint32 height", false}}};
  const auto message = nlohmann::json::parse(advertise(channels));
  EXPECT_EQ(message["op"], "advertise");
  EXPECT_EQ(message["channels"][0]["id"], 3);
  EXPECT_EQ(message["channels"][0]["schemaName"], "sensor_msgs/msg/PointCloud2");
}

struct HubOfTwo {
  Exchange exchange{1000};
  Hub hub{exchange, "", 1000};

  HubOfTwo() {
    exchange.new_channels = {{1, {"/a", "json", "", "", "", true}},
                             {2, {"/b", "json", "", "", "", false}}};
    hub.take_over();
  }

  void publish(std::uint32_t channel, std::size_t bytes) {
    auto frame = std::make_shared<Frame>();
    *frame = {channel, Time{5}, std::vector<std::uint8_t>(bytes)};
    exchange.inbox.push(frame);
    hub.take_over();
  }
};

constexpr const char* kBoth =
    R"({"op":"subscribe","subscriptions":[{"id":10,"channelId":1},{"id":20,"channelId":2}]})";

TEST(ViewerChannels, send_the_last_frame_of_latched_channels_to_late_subscribers) {
  HubOfTwo s;
  s.publish(1, 3);
  s.publish(1, 4);
  s.publish(2, 5);
  ViewerChannels viewer(s.hub);
  EXPECT_TRUE(viewer.take(kBoth, false).empty());
  const auto next = viewer.next();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->frame->bytes.size(), 4U);
  EXPECT_EQ(next->header, data_header(10, Time{5}));
  EXPECT_FALSE(viewer.next()) << "channel 2 keeps nothing";
}

TEST(ViewerChannels, report_errors_for_unknown_channels_and_duplicate_subscriptions) {
  HubOfTwo s;
  ViewerChannels viewer(s.hub);
  for (const char* text : {R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":9}]})",
                           R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1},)"
                           R"({"id":1,"channelId":2}]})",
                           R"({"op":"subscribe","subscriptions":[{"id":5,"channelId":1}]})"}) {
    const auto answers = viewer.take(text, false);
    ASSERT_EQ(answers.size(), 1U) << text;
    EXPECT_EQ(nlohmann::json::parse(answers[0])["level"], 2);
  }
  EXPECT_EQ(viewer.subscriptions(), 1U);
}

TEST(ViewerChannels, drop_queued_frames_after_unsubscribe) {
  HubOfTwo s;
  ViewerChannels viewer(s.hub);
  (void)viewer.take(kBoth, false);
  auto frame = std::make_shared<Frame>();
  frame->channel = 2;
  viewer.offer(frame);
  (void)viewer.take(R"({"op":"unsubscribe","subscriptionIds":[20, 99]})", false);
  EXPECT_FALSE(viewer.next());
  viewer.offer(frame);
  EXPECT_FALSE(viewer.next());
}

TEST(ViewerChannels, limit_the_number_of_invalid_messages_per_viewer) {
  HubOfTwo s;
  ViewerChannels viewer(s.hub);
  for (int i = 0; i < kBadMessagesMax; ++i)
    EXPECT_EQ(viewer.take("nonsense", i % 2 == 0).size(), 1U);
  EXPECT_FALSE(viewer.too_many_bad());
  (void)viewer.take("nonsense", false);
  EXPECT_TRUE(viewer.too_many_bad());
}

TEST(ViewerChannels, count_the_frames_that_a_slow_viewer_loses) {
  HubOfTwo s;
  ViewerChannels viewer(s.hub);
  (void)viewer.take(kBoth, false);
  for (int i = 0; i < 20; ++i) {
    auto frame = std::make_shared<Frame>();
    *frame = {2, Time{i}, std::vector<std::uint8_t>(100)};
    viewer.offer(frame);
  }
  EXPECT_LE(viewer.waiting().bytes(), 1000U);
  EXPECT_EQ(s.exchange.published.frames_dropped, 10U);
}

}  // namespace
}  // namespace rali::view
