#include <memory>

#include <gtest/gtest.h>

#include "rali/factlog/disk_log.hpp"
#include "rali/factlog/folder_for_test.hpp"
#include "rali/factlog/memory_log.hpp"

namespace rali::factlog {
namespace {

/// Requirements on both logs.
class AnyLog : public testing::TestWithParam<bool> {
 protected:
  AnyLog() {
    if (GetParam()) {
      auto disk = DiskLog::open(folder_.path(), {.segment_bytes = 500});
      EXPECT_TRUE(disk.has_value());
      log_ = std::move(*disk);
    } else {
      log_ = std::make_unique<MemoryLog>();
    }
  }

  TestFolder folder_;
  std::unique_ptr<FactLog> log_;
};

TEST_P(AnyLog, returns_the_appended_records) {
  for (std::uint32_t seq = 0; seq < 40; ++seq) {
    EXPECT_EQ(log_->append(key_of(seq), 3, body_of(seq, 90)), Appended::kWritten);
  }
  EXPECT_EQ(log_->size(), 40U);
  ASSERT_TRUE(log_->sync().has_value());
  for (std::uint32_t seq = 0; seq < 40; ++seq) {
    EXPECT_EQ(log_->read(key_of(seq)), body_of(seq, 90));
  }
  const auto missing = log_->read(key_of(40));
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, ErrorCode::kNoAnswer);
}

TEST_P(AnyLog, visits_records_in_order_of_appending_until_stopped) {
  for (const std::uint32_t seq : {7U, 2U, 9U}) {
    ASSERT_EQ(log_->append(key_of(seq), static_cast<std::uint8_t>(seq), {}), Appended::kWritten);
  }
  std::vector<std::uint32_t> visited;
  log_->for_each([&](const RecordKey& key, std::uint8_t kind, std::span<const std::byte>) {
    EXPECT_EQ(kind, key.seq);
    visited.push_back(key.seq);
    return key.seq != 2;
  });
  EXPECT_EQ(visited, (std::vector<std::uint32_t>{7, 2}));
}

TEST_P(AnyLog, accepts_identical_content_of_a_key_but_never_different_content) {
  ASSERT_EQ(log_->append(key_of(1), 3, body_of(1, 20)), Appended::kWritten);
  EXPECT_EQ(log_->append(key_of(1), 3, body_of(1, 20)), Appended::kKnown);
  EXPECT_TRUE(log_->take_findings().empty());
  EXPECT_EQ(log_->append(key_of(1), 3, body_of(2, 20)), Appended::kConflict);
  EXPECT_EQ(log_->append(key_of(1), 4, body_of(1, 20)), Appended::kConflict);
  const FindingList findings = log_->take_findings();
  ASSERT_EQ(findings.size(), 1U) << "once per stream";
  EXPECT_EQ(findings[0].id, "log.conflict");
  EXPECT_EQ(findings[0].severity, Severity::kError);
  EXPECT_EQ(log_->read(key_of(1)), body_of(1, 20));
}

TEST_P(AnyLog, refuses_a_body_above_the_maximum_size) {
  const auto appended = log_->append(key_of(1), 3, Bytes(kBodyMax + 1));
  ASSERT_FALSE(appended.has_value());
  EXPECT_EQ(appended.error().code, ErrorCode::kInput);
  EXPECT_EQ(log_->size(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Logs, AnyLog, testing::Bool(), [](const auto& instance) {
  return std::string(instance.param ? "disk" : "memory");
});

TEST(MemoryLog, loses_only_unsynced_records_at_a_power_loss) {
  MemoryLog log;
  ASSERT_EQ(log.append(key_of(1), 3, body_of(1, 20)), Appended::kWritten);
  ASSERT_TRUE(log.sync().has_value());
  ASSERT_EQ(log.append(key_of(2), 3, body_of(2, 20)), Appended::kWritten);
  log.lose_power();
  EXPECT_TRUE(log.contains(key_of(1)));
  EXPECT_FALSE(log.contains(key_of(2)));
  EXPECT_EQ(log.append(key_of(2), 3, body_of(5, 20)), Appended::kWritten) << "it never was";
}

TEST(MemoryLog, reports_when_it_is_full_and_stays_unchanged) {
  MemoryLog log(100);
  ASSERT_EQ(log.append(key_of(1), 3, body_of(1, 20)), Appended::kWritten);
  EXPECT_EQ(log.free_bytes(), 52U);
  EXPECT_EQ(log.append(key_of(2), 3, body_of(2, 25)), Appended::kFull);
  EXPECT_EQ(log.append(key_of(2), 3, body_of(2, 24)), Appended::kWritten);
  EXPECT_EQ(log.free_bytes(), 0U);
  log.set_capacity(1000);
  EXPECT_EQ(log.append(key_of(3), 3, body_of(3, 24)), Appended::kWritten);
}

}  // namespace
}  // namespace rali::factlog
