#include "rali/io/containers/codec.hpp"

#include <gtest/gtest.h>

#include "rali/io/containers/testing.hpp"

namespace rali::io {
namespace {

using testing::copy;
using testing::first;

class EachCodec : public ::testing::TestWithParam<Compression> {};

INSTANTIATE_TEST_SUITE_P(Codec, EachCodec,
                         ::testing::Values(Compression::kLz4, Compression::kBz2,
                                           Compression::kZstd),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

std::vector<std::byte> some_bytes(std::size_t n) {
  std::vector<std::byte> out(n);
  std::uint32_t state = 1;
  for (std::byte& b : out) {
    state = state * 1664525U + 1013904223U;
    b = static_cast<std::byte>((state >> 24) & 0x3FU);
  }
  return out;
}

TEST_P(EachCodec, restores_inputs_from_empty_to_larger_than_one_buffer) {
  Decompressor decompressor;
  for (const std::size_t n :
       {std::size_t{0}, std::size_t{1}, std::size_t{70'000}, std::size_t{300'000}}) {
    const auto plain = some_bytes(n);
    const auto packed = compress(GetParam(), plain);
    ASSERT_TRUE(packed);
    std::vector<std::byte> out;
    EXPECT_EQ(decompressor.decompress(GetParam(), *packed, n, out), DecodeEnd::kWhole) << n;
    EXPECT_EQ(out, plain);
  }
}

TEST_P(EachCodec, truncated_input_gives_a_prefix_and_is_reported_as_cut) {
  Decompressor decompressor;
  const auto plain = some_bytes(3000);
  const auto packed = compress(GetParam(), plain);
  ASSERT_TRUE(packed);
  for (std::size_t n = 0; n < packed->size(); ++n) {
    std::vector<std::byte> out;
    ASSERT_EQ(decompressor.decompress(GetParam(), first(*packed, n), 3000, out), DecodeEnd::kCut);
    ASSERT_TRUE(std::equal(out.begin(), out.end(), plain.begin()));
  }
}

TEST_P(EachCodec, output_beyond_the_limit_is_refused) {
  Decompressor decompressor;
  const auto packed = compress(GetParam(), some_bytes(100'000));
  ASSERT_TRUE(packed);
  std::vector<std::byte> out;
  EXPECT_EQ(decompressor.decompress(GetParam(), *packed, 99'999, out), DecodeEnd::kTooLong);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(decompressor.decompress(GetParam(), *packed, 1ULL << 62, out), DecodeEnd::kWhole);
  EXPECT_EQ(out.size(), 100'000U);
  EXPECT_LT(out.capacity(), 1'000'000U) << "memory must follow the output, not the claim";
}

TEST_P(EachCodec, previous_contents_of_the_output_are_overwritten) {
  Decompressor decompressor;
  const auto plain = some_bytes(3000);
  const auto packed = compress(GetParam(), plain);
  ASSERT_TRUE(packed);
  std::vector<std::byte> out(300'000, std::byte{0x7F});
  ASSERT_EQ(decompressor.decompress(GetParam(), *packed, 3000, out), DecodeEnd::kWhole);
  EXPECT_EQ(out, plain);
  out.assign(300'000, std::byte{0x7F});
  ASSERT_EQ(decompressor.decompress(GetParam(), *packed, 400'000, out), DecodeEnd::kWhole);
  EXPECT_EQ(out, plain) << "where the size is not the expected one";
  out.assign(300'000, std::byte{0x7F});
  ASSERT_EQ(decompressor.decompress(GetParam(), first(*packed, packed->size() - 1), 400'000, out),
            DecodeEnd::kCut);
  ASSERT_LE(out.size(), plain.size());
  EXPECT_TRUE(std::equal(out.begin(), out.end(), plain.begin()));
}

TEST_P(EachCodec, reports_invalid_input_as_damaged_and_decodes_the_next_frame) {
  Decompressor decompressor;
  std::vector<std::byte> out;
  EXPECT_EQ(decompressor.decompress(GetParam(), copy("this is not a frame at all"), 1000, out),
            DecodeEnd::kDamaged);
  EXPECT_TRUE(out.empty());
  const auto packed = compress(GetParam(), copy("hello"));
  EXPECT_EQ(decompressor.decompress(GetParam(), *packed, 5, out), DecodeEnd::kWhole);
}

TEST_P(EachCodec, consecutive_frames_are_concatenated) {
  Decompressor decompressor;
  auto packed = *compress(GetParam(), copy("hello "));
  const auto second = *compress(GetParam(), copy("world"));
  packed.insert(packed.end(), second.begin(), second.end());
  std::vector<std::byte> out;
  EXPECT_EQ(decompressor.decompress(GetParam(), packed, 11, out), DecodeEnd::kWhole);
  EXPECT_EQ(text_of(out), "hello world");
}

TEST(Codec, names_and_zstd_magic_bytes_are_recognised) {
  EXPECT_EQ(compression_named(""), Compression::kNone);
  EXPECT_EQ(compression_named("lz4"), Compression::kLz4);
  EXPECT_EQ(compression_named("LZ4"), std::nullopt);
  EXPECT_TRUE(is_zstd(copy("\x28\xb5\x2f\xfd")));
  EXPECT_FALSE(is_zstd(copy("\x28\xb5\x2f")));
}

}  // namespace
}  // namespace rali::io
