#include "rali/io/files/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace rali::io {
namespace {

TEST(Text, stamps_keep_every_nanosecond) {
  EXPECT_EQ(parse_stamp("1630577758.569490123")->ns, 1630577758569490123);
  EXPECT_EQ(parse_stamp("1630577758.5694901235")->ns, 1630577758569490124);
  EXPECT_EQ(parse_stamp(" 12 ")->ns, 12000000000);
  EXPECT_EQ(parse_stamp("12.")->ns, 12000000000);
  EXPECT_EQ(parse_stamp("+0.5")->ns, 500000000);
  EXPECT_EQ(parse_stamp("-0.000000001")->ns, -1);
  EXPECT_EQ(parse_stamp("1.5e3")->ns, 1500000000000);
  EXPECT_EQ(format_stamp(Time::from_ns(1630577758569490123)), "1630577758.569490123");
  EXPECT_EQ(format_stamp(Time::from_ns(-1)), "-0.000000001");
  EXPECT_EQ(format_stamp(Time::from_ns(std::numeric_limits<std::int64_t>::min())),
            "-9223372036.854775808");
}

TEST(Text, invalid_stamps_are_refused) {
  for (const char* text : {"", "-", "nan", "inf", "1.2.3", "12s", "1e300", "1_0", "0x10",
                           "99999999999", "9999999999.5", "--1", "+-1", "1630577758569490123"}) {
    EXPECT_FALSE(parse_stamp(text)) << text;
  }
}

TEST(Text, numbers_with_trailing_or_invalid_characters_are_refused) {
  EXPECT_EQ(parse_number(" -1.5e-3\r"), -1.5e-3);
  EXPECT_EQ(parse_number("+7"), 7.0);
  EXPECT_TRUE(std::isnan(*parse_number("nan")));
  EXPECT_TRUE(std::isinf(*parse_number("1e999")));
  EXPECT_EQ(parse_number("1e-999"), 0.0);
  for (const char* text : {"", " ", "1,5", "1.5x", "x", "1 2", "+", "++1", "+-1"}) {
    EXPECT_FALSE(parse_number(text)) << text;
  }
  EXPECT_EQ(parse_integer("-12"), -12);
  EXPECT_FALSE(parse_integer("1.0"));
  EXPECT_FALSE(parse_integer("99999999999999999999"));
}

TEST(Text, fixed_numbers_have_no_negative_zero) {
  EXPECT_EQ(format_fixed(-0.0000001, 6), "0.000000");
  EXPECT_EQ(format_fixed(-0.0000006, 6), "-0.000001");
  EXPECT_EQ(format_fixed(1.0 / 3.0, 3), "0.333");
}

TEST(Text, file_names_sort_in_natural_numeric_order) {
  std::vector<std::string> names = {"s10", "s2", "s1", "s02", "a", "s2b", "10", "9", "s2a"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_EQ(names,
            (std::vector<std::string>{"9", "10", "a", "s1", "s02", "s2", "s2a", "s2b", "s10"}));
  EXPECT_TRUE(natural_less("99999999999999999999998", "99999999999999999999999"));
  EXPECT_FALSE(natural_less("same", "same"));
}

TEST(Text, lines_and_words_are_split_one_by_one) {
  std::string_view rest = "a b\r\n\nlast";
  std::string_view line;
  ASSERT_TRUE(take_line(rest, line));
  EXPECT_EQ(line, "a b");
  EXPECT_EQ(take_word(line), "a");
  EXPECT_EQ(take_word(line), "b");
  EXPECT_EQ(take_word(line), "");
  ASSERT_TRUE(take_line(rest, line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(take_line(rest, line));
  EXPECT_EQ(line, "last");
  EXPECT_FALSE(take_line(rest, line));
}

TEST(Text, quoted_text_has_no_control_characters) {
  EXPECT_EQ(quoted("a\x1b[31m\n"), "'a?[31m?'");
  EXPECT_EQ(quoted(std::string(50, 'x'), 3), "'xxx...'");
}

}  // namespace
}  // namespace rali::io
