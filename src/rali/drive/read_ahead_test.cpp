#include "rali/drive/read_ahead.hpp"

#include <gtest/gtest.h>

#include "rali/base/assert.hpp"
#include "rali/base/internal_error.hpp"
#include "rali/drive/tbb_executor.hpp"

namespace rali::drive {
namespace {

/// Scans with rising stamps, then the end, an error or a fault.
class Counter final : public EventSource {
 public:
  explicit Counter(int n, int fault_at = -1) : n_(n), fault_at_(fault_at) {}

  Result<std::optional<vehicle::Event>> next() override {
    RALI_ASSERT(given_ != fault_at_);
    std::optional<vehicle::Event> event;
    if (given_ < n_) {
      auto scan = std::make_shared<sensor::LidarScan>();
      scan->t_end = Time::from_ns(++given_);
      event = std::shared_ptr<const sensor::LidarScan>(std::move(scan));
    }
    return event;
  }

  double progress() const override { return static_cast<double>(given_) / n_; }

 private:
  int n_, fault_at_, given_ = 0;
};

TEST(ReadAhead, returns_the_same_events_in_the_same_order) {
  Counter source(100);
  ReadAhead ahead(source);
  for (int i = 1; i <= 100; ++i) {
    const auto event = ahead.next();
    ASSERT_TRUE(event && *event);
    EXPECT_EQ(std::get<std::shared_ptr<const sensor::LidarScan>>(**event)->t_end.ns, i);
    EXPECT_NEAR(ahead.progress(), i / 100.0, 1e-9) << "of what was handed out";
  }
  EXPECT_FALSE(*ahead.next());
  EXPECT_FALSE(*ahead.next()) << "the end stays the end";
}

TEST(ReadAhead, can_be_destroyed_before_the_end_of_its_source) {
  Counter source(1000000);
  ReadAhead ahead(source);
  EXPECT_TRUE(*ahead.next());
}

TEST(ReadAhead, rethrows_an_internal_error_to_the_caller) {
  Counter source(10, 3);
  ReadAhead ahead(source);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(*ahead.next());
  EXPECT_THROW((void)ahead.next(), InternalError);
}

TEST(TbbExecutor, runs_the_same_blocks_as_the_serial_one) {
  for (const int threads : {1, 2, 4}) {
    const auto executor = make_executor(threads);
    std::vector<int> block_of(1001, -1);
    executor->for_blocks(1001, 64, [&](std::size_t index, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) block_of[i] = static_cast<int>(index);
    });
    for (std::size_t i = 0; i < block_of.size(); ++i) {
      ASSERT_EQ(block_of[i], static_cast<int>(i / 64)) << threads;
    }
    executor->for_blocks(0, 64, [](std::size_t, std::size_t, std::size_t) { FAIL(); });
  }
}

}  // namespace
}  // namespace rali::drive
