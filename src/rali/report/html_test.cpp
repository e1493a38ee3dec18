#include "rali/report/internal/html.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::report {
namespace {

TEST(Escaped, text_keeps_letters_and_escapes_markup) {
  EXPECT_EQ(escaped("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(escaped("Gr\xC3\xBC\xC3\x9F\x65 \xE2\x82\xAC \xF0\x9F\x9A\x97"),
            "Gr\xC3\xBC\xC3\x9F\x65 \xE2\x82\xAC \xF0\x9F\x9A\x97");
  EXPECT_EQ(escaped(std::string_view("a\0b\x1B[31m\n", 9)), "a b [31m ");
}

TEST(Escaped, invalid_utf8_bytes_become_the_replacement_character) {
  const std::string sign = "\xEF\xBF\xBD";
  EXPECT_EQ(escaped("\xFF"), sign);
  EXPECT_EQ(escaped("\xC3"), sign) << "cut";
  EXPECT_EQ(escaped("\xC0\xAF"), sign + sign) << "overlong slash";
  EXPECT_EQ(escaped("\xED\xA0\x80"), sign + sign + sign) << "surrogate";
  EXPECT_EQ(escaped("\xC3<"), sign + "&lt;") << "markup is not swallowed";
}

TEST(Numbers, are_formatted_with_few_digits_and_units) {
  EXPECT_EQ(metres(0.0061), "0.006 m");
  EXPECT_EQ(metres(87.343), "87.3 m");
  EXPECT_EQ(metres(1204.4), "1204 m");
  EXPECT_EQ(percent(0.0123), "1.2 %");
  EXPECT_EQ(percent(0.27), "27 %");
  EXPECT_EQ(percent(0.0), "0 %");
  EXPECT_EQ(counted(999.0), "999");
  EXPECT_EQ(counted(1530968.0),
            "1\xE2\x80\xAF"
            "530\xE2\x80\xAF"
            "968");
  EXPECT_EQ(counted(-1000.0),
            "-1\xE2\x80\xAF"
            "000");
}

TEST(Numbers, unknown_or_infinite_are_shown_as_a_dash) {
  const std::string dash = "\xE2\x80\x93";
  EXPECT_EQ(fixed(std::numeric_limits<double>::infinity(), 2), dash);
  EXPECT_EQ(metres(Number()), dash);
  EXPECT_EQ(percent(Number()), dash);
  EXPECT_EQ(counted(kUnknown), dash);
}

TEST(Numbers, absurdly_large_are_shown_as_over_a_limit) {
  EXPECT_EQ(metres(6e10), "over 100 km");
  EXPECT_EQ(at_most(6e10, 1000.0, 2), "over 1000");
  EXPECT_EQ(at_most(5.5, 1000.0, 2), "5.50");
}

TEST(Table, replaces_columns_of_only_zeros_or_unknowns_by_a_sentence) {
  Table table({"vehicle", "path", "dropped", "latency"});
  table.row({"v1", "12.0 m", "0", "not known"});
  table.row({"v2", "0.000 m", "0", "\xE2\x80\x93"});
  const std::string html = table.lean_html();
  EXPECT_NE(html.find("<th>vehicle</th><th>path</th></tr>"), std::string::npos) << html;
  EXPECT_NE(html.find("Zero in every row: dropped."), std::string::npos) << html;
  EXPECT_NE(html.find("Not known: latency."), std::string::npos) << html;
  EXPECT_EQ(html.find("<td>0</td>"), std::string::npos);
}

TEST(Base64, agrees_with_the_vectors_of_rfc_4648) {
  const auto of = [](std::string_view text) {
    return base64(std::as_bytes(std::span(text.data(), text.size())));
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foo"), "Zm9v");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace rali::report
