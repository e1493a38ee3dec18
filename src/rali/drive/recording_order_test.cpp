#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/fake_recording_for_test.hpp"
#include "rali/drive/recording_events.hpp"

namespace rali::drive {
namespace {

/// Clouds and inertial data of six seconds in a given order.
enum class Mixed { kReversed, kShuffled, kHalvesSwapped, kByTopic };

std::vector<Message> messages_of(double seconds, Mixed mixed) {
  std::vector<Message> messages;
  const int steps = static_cast<int>(std::lround(seconds * 100.0));
  for (int i = 0; i < steps; ++i) {
    const double t = 1000.0 + 0.01 * i;
    messages.push_back({false, t, t + 0.002});
    if (i % 10 == 9) messages.push_back({true, t - 0.09, t + 0.005});
  }
  Rng rng(5);
  switch (mixed) {
    case Mixed::kReversed:
      std::reverse(messages.begin(), messages.end());
      break;
    case Mixed::kShuffled:
      for (std::size_t i = messages.size(); i > 1; --i) {
        std::swap(messages[i - 1], messages[rng.below(i)]);
      }
      break;
    case Mixed::kHalvesSwapped:
      std::rotate(messages.begin(), messages.begin() + steps / 2, messages.end());
      break;
    case Mixed::kByTopic:
      std::stable_sort(messages.begin(), messages.end(),
                       [](const Message& a, const Message& b) { return a.cloud < b.cloud; });
      break;
  }
  return messages;
}

TEST(RecordingOrder, returns_all_scans_of_an_unordered_file_sorted_by_stamp) {
  for (const Mixed mixed :
       {Mixed::kReversed, Mixed::kShuffled, Mixed::kHalvesSwapped, Mixed::kByTopic}) {
    const io::TestFolder folder;
    FakeRecording recording;
    for (const Message& m : messages_of(6.0, mixed)) recording.add(m);
    const auto source = open_recording_events({recording.save(folder)}, {});
    ASSERT_TRUE(source) << source.error().message();
    const Drained d = drain(**source);
    EXPECT_EQ(d.scans, 60U) << static_cast<int>(mixed);
    EXPECT_EQ(d.imu, 600U);
    EXPECT_TRUE(d.ordered);
    EXPECT_NEAR(d.first_scan.s(), 1000.09, 2e-3);
    EXPECT_NEAR(d.last_scan.s(), 1005.99, 2e-3);
    const InputReport& report = (*source)->report();
    EXPECT_EQ(report.gaps.jumps + report.gaps.late, 0U);
    EXPECT_FALSE(report.gaps.damaged) << "nothing is lost";
    EXPECT_TRUE(has(report.findings, "D19")) << "but it is said";
  }
}

TEST(RecordingOrder, sorts_by_header_if_record_times_only_follow_the_file_order) {
  for (const bool still : {false, true}) {
    const io::TestFolder folder;
    FakeRecording recording;
    double record_s = 5000.0;
    for (Message m : messages_of(6.0, Mixed::kShuffled)) {
      m.record_s = still ? 5000.0 : (record_s += 0.009);
      recording.add(m);
    }
    const auto source = open_recording_events({recording.save(folder)}, {});
    ASSERT_TRUE(source) << source.error().message();
    const Drained d = drain(**source);
    EXPECT_EQ(d.scans, 60U);
    EXPECT_EQ(d.imu, 600U);
    EXPECT_EQ((*source)->report().lidar_stamp, "header");
    EXPECT_NEAR(d.last_scan.s(), 1005.99, 2e-3);
  }
}

TEST(RecordingOrder, removes_a_backward_clock_jump_in_headers_and_record_times) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 5.0, as_is);
  recording.add_seconds(1002.0, 3.0, as_is);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 80U);
  EXPECT_NEAR(d.last_scan.s(), 1007.99, 0.02);
  EXPECT_EQ((*source)->report().gaps.late, 0U);
}

TEST(RecordingOrder, counts_scans_beyond_the_ordering_window_as_lost) {
  const io::TestFolder folder;
  FakeRecording recording(64U << 20);  // a single chunk has no index that shows the order
  std::vector<Message> messages = messages_of(8.0, Mixed::kReversed);
  std::reverse(messages.begin(), messages.end());
  std::swap_ranges(messages.begin() + 500, messages.begin() + 560, messages.begin() + 700);
  for (const Message& m : messages) recording.add(m);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  const InputReport& report = (*source)->report();
  EXPECT_TRUE(d.ordered);
  EXPECT_GT(report.gaps.late_scans, 0U);
  EXPECT_EQ(report.gaps.late_scans, 80U - d.scans);
  EXPECT_TRUE(report.gaps.damaged) << "exit code 3";
  EXPECT_EQ(report.gaps.jumps, 0U) << "no stamp is moved";
}

TEST(RecordingOrder, files_in_the_wrong_order_are_read_in_order_of_time) {
  const io::TestFolder folder;
  FakeRecording first, second;
  first.add_seconds(1000.0, 4.0, as_is);
  second.add_seconds(1004.0, 4.0, as_is);
  const std::string a = first.save(folder, "a.mcap"), b = second.save(folder, "b.mcap");
  const auto source = open_recording_events({b, a}, {});
  ASSERT_TRUE(source);
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 80U);
  EXPECT_TRUE(d.ordered);
  EXPECT_NEAR(d.first_scan.s(), 1000.09, 2e-3);
  EXPECT_NEAR(d.last_scan.s(), 1007.99, 2e-3);
  EXPECT_EQ((*source)->report().gaps.jumps, 0U);
}

TEST(RecordingOrder, counts_scans_with_only_nan_points_as_missing) {
  const io::TestFolder folder;
  FakeRecording recording;
  recording.add_seconds(1000.0, 3.0, as_is);
  recording.nan = true;
  recording.add_seconds(1003.0, 0.2, as_is);
  recording.nan = false;
  recording.add_seconds(1003.2, 2.0, as_is);
  recording.nan = true;
  recording.add_seconds(1005.2, 0.3, as_is);
  const auto source = open_recording_events({recording.save(folder)}, {});
  ASSERT_TRUE(source) << source.error().message();
  const Drained d = drain(**source);
  EXPECT_EQ(d.scans, 50U);
  const InputReport& report = (*source)->report();
  EXPECT_EQ(report.gaps.empty_scans, 5U);
  EXPECT_NEAR(report.gaps.missing_s, 0.5, 0.02);
  EXPECT_TRUE(report.gaps.damaged) << "exit code 3";
  EXPECT_TRUE(has(report.findings, "D05"));
}

}  // namespace
}  // namespace rali::drive
