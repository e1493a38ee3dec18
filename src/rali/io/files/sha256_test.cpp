#include "rali/io/files/sha256.hpp"

#include <string_view>

#include <gtest/gtest.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

std::string hex_of(std::string_view text) {
  return sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
}

// Vectors: NIST CSRC, "SHA256.pdf" examples and SHA256ShortMsg.rsp.
TEST(Sha256, agrees_with_the_nist_vectors) {
  EXPECT_EQ(hex_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hex_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hex_of("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnop"
                   "qklmnopqrlmnopqrsmnopqrstnopqrstu"),
            "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(hex_of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, is_independent_of_how_the_input_is_split) {
  const std::string text(200, 'q');
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    Sha256 hash;
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    hash.update(bytes.first(cut));
    hash.update(bytes.subspan(cut));
    Sha256 whole;
    whole.update(bytes);
    ASSERT_EQ(hash.finish(), whole.finish()) << cut;
  }
}

TEST(Sha256, of_a_file_is_that_of_its_content) {
  const TestFolder folder;
  ASSERT_TRUE(write_file_atomic(folder.path("a.txt"), std::string_view("abc")));
  EXPECT_EQ(sha256_file(folder.path("a.txt")).value(), hex_of("abc"));
}

TEST(Sha256, of_a_missing_file_is_an_error_that_names_it) {
  const auto result = sha256_file("/nowhere/x");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().where, "/nowhere/x");
}

}  // namespace
}  // namespace rali::io
