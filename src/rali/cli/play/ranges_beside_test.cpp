#include "rali/cli/play/ranges_beside.hpp"

#include <gtest/gtest.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/wire/decode.hpp"

namespace rali::cli {
namespace {

/// Ten messages of one topic, a second apart.
class TickSource final : public io::MessageSource {
 public:
  TickSource() {
    io::Topic topic;
    topic.name = "/imu";
    topic.type = "sensor_msgs/msg/Imu";
    topic.encoding = wire::Encoding::kCdr;
    topics_.push_back(topic);
  }

  [[nodiscard]] const std::vector<io::Topic>& topics() const override { return topics_; }

  void select(std::function<bool(const io::Topic&)> /*keep*/) override {}

  [[nodiscard]] Result<bool> next(io::RawMessage& out) override {
    if (at_ == 10) return false;
    out = {0, Time::from_s(100.0 + at_++), {}, 0};
    return true;
  }

  [[nodiscard]] const io::SourceHealth& health() const override { return health_; }

  [[nodiscard]] double progress() const override { return 0.5; }

  [[nodiscard]] std::optional<std::pair<Time, Time>> span() const override { return {}; }

  [[nodiscard]] std::optional<bool> in_order() const override { return {}; }

 private:
  std::vector<io::Topic> topics_;
  io::SourceHealth health_;
  int at_ = 0;
};

std::string ranges_file(const std::string& text) {
  // Tests run in parallel: each has its own file.
  const std::string path = testing::TempDir() + "ranges_beside_" +
                           testing::UnitTest::GetInstance()->current_test_info()->name() + ".csv";
  const std::string whole = "stamp_s,from,to,range_m,rssi_dbm\n" + text;
  EXPECT_TRUE(io::write_file_atomic(path, std::as_bytes(std::span(whole))));
  return path;
}

TEST(RangesBeside, ranges_of_the_vehicle_are_merged_with_the_messages_by_time) {
  const std::string path =
      ranges_file("102.5,v2,v1,7.5,-80\n101.5,v1,v2,7.25,\n103.5,v2,v3,9,-80\n99,v1,v2,1,\n");
  auto source = with_ranges(std::make_unique<TickSource>(), path, "v1");
  ASSERT_TRUE(source) << source.error().message();
  (*source)->select([](const io::Topic&) { return true; });
  ASSERT_EQ((*source)->topics().size(), 2U);
  std::vector<double> times_s;
  std::vector<double> ranges_m;
  io::RawMessage message;
  while ((*source)->next(message).value()) {
    times_s.push_back(message.t_record.s());
    if ((*source)->topics()[message.topic].type != "rali_msgs/msg/Range") continue;
    const auto range = wire::decode_range(message.data, wire::Encoding::kCdr);
    ASSERT_TRUE(range);
    ranges_m.push_back(range->range_m);
    EXPECT_LT(seconds_between(range->stamp, message.t_record), 0.01);
  }
  EXPECT_EQ(ranges_m, (std::vector<double>{7.25, 7.5}));  // the one before the start is dropped
  EXPECT_EQ(times_s.size(), 12U);
  EXPECT_TRUE(std::is_sorted(times_s.begin(), times_s.end()));
}

TEST(RangesBeside, a_file_without_a_range_of_the_vehicle_is_an_error) {
  const auto source =
      with_ranges(std::make_unique<TickSource>(), ranges_file("101,v1,v2,7,\n"), "v3");
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().message().find("no range of 'v3'"), std::string::npos);
}

TEST(RangesBeside, an_invalid_row_is_an_error_with_its_line) {
  const auto source =
      with_ranges(std::make_unique<TickSource>(), ranges_file("101,v1,v2,far,\n"), "v1");
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().message().find(":2"), std::string::npos);
}

}  // namespace
}  // namespace rali::cli
