#include "rali/base/counted.hpp"

#include <cstdint>

#include <gtest/gtest.h>

namespace rali {
namespace {

TEST(Counted, uses_the_singular_for_one_and_the_plural_otherwise) {
  EXPECT_EQ(counted(std::uint64_t{0}, "sweep"), "0 sweeps");
  EXPECT_EQ(counted(1, "sweep"), "1 sweep");
  EXPECT_EQ(counted(std::size_t{2}, "point cloud topic"), "2 point cloud topics");
}

}  // namespace
}  // namespace rali
