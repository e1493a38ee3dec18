#include "rali/base/result.hpp"

#include <gtest/gtest.h>

#include "rali/base/assert.hpp"
#include "rali/base/internal_error.hpp"

namespace rali {
namespace {

TEST(Error, message_is_location_then_cause_then_remedy) {
  const Error e{ErrorCode::kInput, "the file is cut off", "a.bag:offset 12", "Run rali doctor."};
  EXPECT_EQ(e.message(), "a.bag:offset 12: the file is cut off. Run rali doctor.");
}

TEST(Error, message_omits_empty_parts) {
  EXPECT_EQ((Error{ErrorCode::kInput, "no topic", "", ""}).message(), "no topic.");
  EXPECT_EQ((Error{ErrorCode::kInput, "It ends.", "x", ""}).message(), "x: It ends.");
  EXPECT_EQ((Error{ErrorCode::kInput, "", "", ""}).message(), "");
}

Result<int> half(int v) {
  if (v % 2 != 0) return fail(ErrorCode::kNoAnswer, "v", "odd");
  return v / 2;
}

TEST(Result, carries_a_value_or_an_error) {
  EXPECT_EQ(half(4).value(), 2);
  const Result<int> odd = half(3);
  ASSERT_FALSE(odd.has_value());
  EXPECT_EQ(odd.error().code, ErrorCode::kNoAnswer);
  EXPECT_EQ(odd.error().message(), "v: odd.");
}

TEST(Assert, names_expression_file_and_line) {
  EXPECT_NO_THROW(RALI_ASSERT(1 + 1 == 2));
  try {
    RALI_ASSERT(1 + 1 == 3);
    FAIL() << "an assertion that does not hold must throw";
  } catch (const InternalError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("1 + 1 == 3"), std::string::npos);
    EXPECT_NE(text.find("result_test.cpp:"), std::string::npos);
  }
}

}  // namespace
}  // namespace rali
