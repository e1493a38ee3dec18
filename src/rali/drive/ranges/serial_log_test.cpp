#include "rali/drive/ranges/serial_log.hpp"

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

/// A Nodeframe3 of radio 1 that measured to radio 2.
std::string frame(std::uint32_t time_ms, double range_m) {
  std::string bytes(21 + 7 + 1, '\0');
  const auto put = [&](std::size_t at, std::uint32_t value, std::size_t n) {
    for (std::size_t k = 0; k < n; ++k) bytes[at + k] = static_cast<char>(value >> (8 * k));
  };
  put(0, 0x55, 1);
  put(1, 0x05, 1);
  put(2, static_cast<std::uint32_t>(bytes.size()), 2);
  put(5, 1, 1);
  put(6, time_ms, 4);
  put(10, time_ms + 77, 4);
  put(20, 1, 1);
  put(22, 2, 1);
  put(23, static_cast<std::uint32_t>(std::lround(1000.0 * range_m)), 3);
  unsigned sum = 0;
  for (const char c : bytes) sum += static_cast<unsigned char>(c);
  bytes.back() = static_cast<char>(sum);
  return bytes;
}

std::string hex(const std::string& bytes) {
  std::string text;
  for (const char c : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return text;
}

/// Frames every 20 ms from host time 1000 s on; each arrives 5 to 60 ms later, cut in two rows.
std::string log_of(int frames) {
  Rng rng(3, "arrivals");
  std::string text = "stamp_s,hex\n";
  double last_s = 0.0;
  for (int i = 0; i < frames; ++i) {
    const std::string bytes = frame(static_cast<std::uint32_t>(20 * i), 3.0 + 0.01 * i);
    const double delay_s = 0.005 + (rng.uniform() < 0.3 ? 0.0 : 0.055 * rng.uniform());
    last_s = std::max(last_s, 1000.0 + 0.02 * i + delay_s);
    text += fmt::format("{:.6f},{}\n", last_s - 0.001, hex(bytes.substr(0, 11)));
    text += fmt::format("{:.6f},{}\n", last_s, hex(bytes.substr(11)));
  }
  return text;
}

SerialLog log_at(const std::string& path) {
  return {path, VehicleId{0}, {{2, io::RadioEnd{VehicleId{1}, 0}}}};
}

// Arrivals scatter by 55 ms; the measurements follow the radio's own regular clock.
TEST(SerialLog, stamps_follow_the_lower_envelope_of_the_arrivals) {
  const io::TestFolder folder;
  const auto ranges = read_serial_log(log_at(folder.write("v1.csv", log_of(500))), {});
  ASSERT_TRUE(ranges) << ranges.error().message();
  ASSERT_EQ(ranges->samples.size(), 500U);
  for (std::size_t i = 100; i < 500; ++i) {
    const sensor::RangeSample& sample = ranges->samples[i];
    EXPECT_NEAR(sample.t.s(), 1000.0 + 0.02 * static_cast<double>(i) + 0.005, 0.003) << i;
    EXPECT_NEAR(sample.range_m, 3.0 + 0.01 * static_cast<double>(i), 0.0006);
    EXPECT_EQ(sample.from, VehicleId{0}) << "the radio that no list names is the recorder's";
    EXPECT_EQ(sample.to, VehicleId{1});
  }
  RangeOptions record;
  record.stamp = RangeStamp::kRecord;
  const auto by_arrival = read_serial_log(log_at(folder.path("v1.csv")), record);
  ASSERT_TRUE(by_arrival);
  EXPECT_GT(by_arrival->samples[200].t.s(), ranges->samples[200].t.s() - 1e-9);
}

TEST(SerialLog, ranges_are_merged_with_those_of_tables_by_time) {
  const io::TestFolder folder;
  RangeOptions options;
  options.names = {{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}};
  options.files = {{folder.write("r.csv", "stamp_s,from,to,range_m\n1001.5,v2,v1,7\n"), {}}};
  options.serial_logs = {log_at(folder.write("v1.csv", log_of(100)))};
  const auto list = read_range_files(options);
  ASSERT_TRUE(list) << list.error().message();
  EXPECT_EQ(list->samples.size(), 101U);
  for (std::size_t i = 1; i < list->samples.size(); ++i) {
    EXPECT_LE(list->samples[i - 1].t, list->samples[i].t);
  }
}

TEST(SerialLog, refuses_invalid_logs_with_an_explanation) {
  const io::TestFolder folder;
  const auto error_of = [&](const std::string& text) {
    const auto refused = read_serial_log(log_at(folder.write("x.log", text)), {});
    return refused ? std::string("none") : refused.error().message();
  };
  EXPECT_NE(error_of(frame(0, 3.0) + frame(20, 3.0)).find("stamp_s,hex"), std::string::npos);
  EXPECT_NE(error_of("time,data\n1,55\n").find("no log of a serial port"), std::string::npos);
  EXPECT_NE(error_of("stamp_s,hex\n1.0,5\n").find("x.log:2: hex is no list of bytes"),
            std::string::npos);
  EXPECT_NE(error_of("stamp_s,hex\n1.0,00ff\n").find("holds no frame"), std::string::npos);
}

TEST(SerialLog, damage_is_reported_once) {
  const io::TestFolder folder;
  std::string bytes = frame(0, 3.0);
  bytes[24] = '\x7f';
  const std::string text = log_of(50) + "1002.0," + hex(bytes) + "\n";
  const auto ranges = read_serial_log(log_at(folder.write("v1.csv", text)), {});
  ASSERT_TRUE(ranges);
  ASSERT_EQ(ranges->findings.size(), 1U);
  EXPECT_NE(ranges->findings[0].text.find("1 frame with a wrong checksum"), std::string::npos)
      << ranges->findings[0].text;
}

}  // namespace
}  // namespace rali::drive
