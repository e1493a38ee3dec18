#include "rali/base/executor.hpp"

#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace rali {
namespace {

using Block = std::tuple<std::size_t, std::size_t, std::size_t>;

std::vector<Block> blocks_of(std::size_t n, std::size_t block) {
  std::vector<Block> out;
  SerialExecutor executor;
  executor.for_blocks(n, block, [&](std::size_t index, std::size_t begin, std::size_t end) {
    out.emplace_back(index, begin, end);
  });
  return out;
}

TEST(SerialExecutor, splits_the_loop_into_ordered_blocks_with_a_shorter_last_one) {
  EXPECT_EQ(blocks_of(10, 4), (std::vector<Block>{{0, 0, 4}, {1, 4, 8}, {2, 8, 10}}));
  EXPECT_EQ(blocks_of(8, 4), (std::vector<Block>{{0, 0, 4}, {1, 4, 8}}));
}

TEST(SerialExecutor, runs_no_block_for_an_empty_loop) { EXPECT_TRUE(blocks_of(0, 512).empty()); }

TEST(SerialExecutor, runs_one_block_if_the_loop_is_shorter_than_a_block) {
  EXPECT_EQ(blocks_of(3, 512), (std::vector<Block>{{0, 0, 3}}));
}

TEST(SerialExecutor, visits_every_item_exactly_once) {
  for (std::size_t n = 1; n < 40; ++n) {
    for (std::size_t block = 1; block < 12; ++block) {
      std::size_t next = 0;
      std::size_t index = 0;
      for (const auto& [i, begin, end] : blocks_of(n, block)) {
        EXPECT_EQ(i, index++);
        EXPECT_EQ(begin, next);
        EXPECT_GT(end, begin);
        next = end;
      }
      EXPECT_EQ(next, n);
    }
  }
}

}  // namespace
}  // namespace rali
