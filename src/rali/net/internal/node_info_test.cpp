#include "rali/net/internal/node_info.hpp"

#include <gtest/gtest.h>

namespace rali::net {
namespace {

NodeInfo example() {
  NodeInfo info;
  info.participant.fill(0xAA);
  info.node_namespace = "/v1";
  info.node_name = "rali";
  info.readers.resize(1);
  info.readers[0].fill(0xBB);
  info.writers.resize(2);
  info.writers[0].fill(0xCC);
  info.writers[1].fill(0xDD);
  return info;
}

void add(std::vector<std::uint8_t>& out, std::size_t n, std::uint8_t value) {
  out.insert(out.end(), n, value);
}

void add(std::vector<std::uint8_t>& out, std::initializer_list<std::uint8_t> bytes) {
  out.insert(out.end(), bytes);
}

TEST(NodeInfo, has_the_byte_layout_of_rmw_dds_common) {
  std::vector<std::uint8_t> expected{0, 1, 0, 0};
  add(expected, 16, 0xAA);
  add(expected, {1, 0, 0, 0});                         // one node
  add(expected, {4, 0, 0, 0, '/', 'v', '1', 0});       // its namespace
  add(expected, {5, 0, 0, 0, 'r', 'a', 'l', 'i', 0});  // its name
  add(expected, {0, 0, 0, 1, 0, 0, 0});                // to a multiple of 4; one reader
  add(expected, 16, 0xBB);
  add(expected, {2, 0, 0, 0});
  add(expected, 16, 0xCC);
  add(expected, 16, 0xDD);
  EXPECT_EQ(encode_node_info(example(), 16), expected);
}

TEST(NodeInfo, of_humble_has_eight_zeros_after_each_gid) {
  const auto bytes = encode_node_info(example(), 24);
  EXPECT_EQ(bytes.size(), encode_node_info(example(), 16).size() + 4 * 8);
  EXPECT_EQ(bytes[4 + 15], 0xAA);
  EXPECT_EQ(bytes[4 + 16], 0);
  EXPECT_EQ(bytes[4 + 23], 0);
  EXPECT_EQ(bytes[4 + 24], 1);
}

}  // namespace
}  // namespace rali::net
