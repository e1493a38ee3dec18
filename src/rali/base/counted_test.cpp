#include "rali/base/counted.hpp"

#include <cstdint>

#include <gtest/gtest.h>

namespace rali {
namespace {

TEST(Counted, one_has_no_s_and_all_others_have) {
  EXPECT_EQ(counted(std::uint64_t{0}, "sweep"), "0 sweeps");
  EXPECT_EQ(counted(1, "sweep"), "1 sweep");
  EXPECT_EQ(counted(std::size_t{2}, "point cloud topic"), "2 point cloud topics");
}

}  // namespace
}  // namespace rali
