#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/lzf.hpp"

namespace rali::io {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto view = text_bytes(text);
  return {view.begin(), view.end()};
}

template <class T>
void append(std::string& out, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  out.append(raw, sizeof value);
}

std::string error_of(std::string_view text) {
  const auto cloud = parse_pcd(bytes_of(text), "a.pcd");
  return cloud ? std::string("no error") : cloud.error().message();
}

constexpr const char* kAscii =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z ring\n"
    "SIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2.5 -3 7\nnan nan nan 65535\n";

TEST(Pcd, ascii_values_are_read) {
  const auto cloud = parse_pcd(bytes_of(kAscii), "a.pcd");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->encoding, "ascii");
  EXPECT_EQ(cloud->point_step, 14U);
  EXPECT_EQ(cloud->column(1)[0], 2.5);
  EXPECT_TRUE(std::isnan(cloud->column(0)[1]));
  EXPECT_EQ(cloud->column(3), (std::vector<double>{7, 65535}));
  EXPECT_FALSE(cloud->viewpoint);
}

/// A short file must be an error, never a cloud with invented points.
TEST(Pcd, ascii_truncated_at_any_byte_is_an_error) {
  const std::string text = kAscii;
  for (std::size_t n = 0; n + 6 < text.size(); ++n) {
    EXPECT_FALSE(parse_pcd(bytes_of(text.substr(0, n)), "a.pcd")) << n;
  }
}

std::string binary_header(std::string_view data, int points) {
  return "VERSION 0.7\nFIELDS x _ stamp ring\nSIZE 4 1 8 1\nTYPE F U U I\nCOUNT 1 3 1 2\nWIDTH " +
         std::to_string(points) + "\nHEIGHT 1\nPOINTS " + std::to_string(points) + "\nDATA " +
         std::string(data) + "\n";
}

std::string binary_body() {
  std::string body;
  for (int i = 0; i < 2; ++i) {
    append(body, 1.5F + static_cast<float>(i));
    body += "pad";
    append(body, std::uint64_t{1} << 53);
    append(body, std::int8_t{-5});
    append(body, std::int8_t{6});
  }
  return body;
}

void expect_binary_content(const Result<CloudFile>& cloud) {
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->size(), 2U);
  ASSERT_EQ(cloud->point_step, 17U);
  ASSERT_EQ(cloud->fields.size(), 3U) << "padding is no field";
  EXPECT_EQ(cloud->column(0), (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(cloud->fields[1].type, wire::FieldType::kFloat64);
  EXPECT_EQ(cloud->column(1), (std::vector<double>{9007199254740992.0, 9007199254740992.0}));
  EXPECT_EQ(cloud->fields[2].offset, 15U);
  EXPECT_EQ(cloud->fields[2].count, 2U);
  EXPECT_EQ(cloud->column(2), (std::vector<double>{-5, -5}));
}

TEST(Pcd, binary_skips_padding_and_widens_64_bit_integers) {
  expect_binary_content(parse_pcd(bytes_of(binary_header("binary", 2) + binary_body()), "a.pcd"));
}

TEST(Pcd, extra_bytes_after_the_last_point_are_ignored) {
  expect_binary_content(
      parse_pcd(bytes_of(binary_header("binary", 2) + binary_body() + "stray"), "a.pcd"));
}

TEST(Pcd, binary_truncated_at_any_byte_is_an_error_with_the_point_count) {
  const std::string whole = binary_header("binary", 2) + binary_body();
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_FALSE(parse_pcd(bytes_of(whole.substr(0, n)), "a.pcd")) << n;
  }
  EXPECT_EQ(error_of(whole.substr(0, whole.size() - 1)), "a.pcd: is cut: 1 of 2 points are there.");
}

/// The same points as columns, stored as LZF literals.
std::string compressed_file() {
  std::string columns;
  append(columns, 1.5F);
  append(columns, 2.5F);
  columns += "padpad";
  append(columns, std::uint64_t{1} << 53);
  append(columns, std::uint64_t{1} << 53);
  columns += "\xfb\x06\xfb\x06";
  std::string packed;
  for (std::size_t i = 0; i < columns.size(); i += 32) {
    const std::string part = columns.substr(i, 32);
    packed += static_cast<char>(part.size() - 1);
    packed += part;
  }
  std::string file = binary_header("binary_compressed", 2);
  append(file, static_cast<std::uint32_t>(packed.size()));
  append(file, static_cast<std::uint32_t>(columns.size()));
  return file + packed;
}

TEST(Pcd, compressed_columns_become_points) {
  expect_binary_content(parse_pcd(bytes_of(compressed_file()), "a.pcd"));
}

TEST(Pcd, compressed_truncated_or_changed_at_any_byte_never_crashes) {
  const std::string whole = compressed_file();
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_FALSE(parse_pcd(bytes_of(whole.substr(0, n)), "a.pcd")) << n;
    for (const char c : {'\x00', '\x1f', '\x20', '\xff', '9'}) {
      std::string wrong = whole;
      wrong[n] = c;
      const auto cloud = parse_pcd(bytes_of(wrong), "a.pcd");
      if (!cloud) continue;
      EXPECT_EQ(cloud->data.size(), cloud->size() * cloud->point_step);
    }
  }
}

TEST(Pcd, huge_sizes_are_refused_before_memory_is_allocated) {
  std::string file = binary_header("binary_compressed", 200000000);
  append(file, std::uint32_t{4});
  append(file, std::uint32_t{3400000000U});
  EXPECT_NE(error_of(file + "abcd").find("4 compressed bytes cannot stand for 3400000000"),
            std::string::npos);
  EXPECT_NE(error_of("FIELDS x\nSIZE 4\nTYPE F\nWIDTH 4294967295\nHEIGHT 4294967295\nDATA binary\n")
                .find("more than a file can hold"),
            std::string::npos);
  EXPECT_NE(error_of("FIELDS x\nSIZE 4\nTYPE F\nPOINTS 4294967295\nDATA ascii\n1\n")
                .find("more than 4 GiB"),
            std::string::npos);
  EXPECT_NE(error_of("FIELDS x\nSIZE 4\nTYPE F\nPOINTS 1000000000\nDATA ascii\n1\n")
                .find("1 of 1000000000 points"),
            std::string::npos);
}

TEST(Pcd, errors_name_file_and_line) {
  EXPECT_EQ(error_of("VERSION 0.7\nFIELDS x\nSIZE 4 4\nTYPE F\nWIDTH 1\nDATA ascii\n"),
            "a.pcd:6: SIZE has 2 entries for 1 fields.");
  EXPECT_EQ(error_of("FIELDS x\nSIZE 3\nTYPE F\nWIDTH 1\nDATA ascii\n"),
            "a.pcd:5: field 'x' has TYPE F of SIZE 3, which does not exist.");
  EXPECT_EQ(error_of("FIELDS x\nSIZE 4\nTYPE F\nWIDTH 2\nDATA ascii\n1\n1,5\n"),
            "a.pcd:7: '1,5' is no value for field 'x'.");
  EXPECT_EQ(error_of("FIELDS x\nSIZE 4\nTYPE F\nWIDTH 2\nDATA ascii\n1 2\n1\n"),
            "a.pcd:6: has more than the 1 declared fields.");
  EXPECT_EQ(error_of("FIELDS x\nSIZE 1\nTYPE U\nWIDTH 1\nDATA ascii\n256\n"),
            "a.pcd:6: '256' is no value for field 'x'.");
  EXPECT_EQ(error_of("FIELDS x\nBANANA\n"), "a.pcd:2: 'BANANA' is no keyword of a PCD header.");
  EXPECT_EQ(error_of("FIELDS x\nSIZE 4\nTYPE F\n"), "a.pcd: the PCD header has no DATA line.");
}

TEST(Pcd, organised_clouds_and_viewpoints_are_kept) {
  const auto cloud = parse_pcd(bytes_of("FIELDS x\nSIZE 4\nTYPE F\nWIDTH 3\nHEIGHT 2\n"
                                        "VIEWPOINT 1 2 3 0 0 0 1\nDATA ascii\n1\n2\n3\n4\n5\n6\n"),
                               "a.pcd");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->width, 3U);
  EXPECT_EQ(cloud->height, 2U);
  ASSERT_TRUE(cloud->viewpoint);
  EXPECT_EQ(cloud->viewpoint->p, geometry::Vec3(1, 2, 3));
  EXPECT_NEAR(cloud->viewpoint->R(0, 0), -1.0, 1e-12);  // half a turn about z
}

TEST(Pcd, disagreeing_counts_are_reported) {
  const auto cloud = parse_pcd(
      bytes_of("FIELDS x\nSIZE 4\nTYPE F\nWIDTH 5\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1\n2\n"),
      "a.pcd");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->size(), 2U);
  ASSERT_EQ(cloud->findings.size(), 1U);
  EXPECT_EQ(cloud->findings[0].text, "a.pcd: WIDTH 5 x HEIGHT 1 is not POINTS 2; POINTS taken");
}

TEST(Lzf, back_references_may_overlap_their_output) {
  // literal 'a','b'; then length 2+3 from distance 2: "ababa"
  const std::string packed = std::string("\x01") + "ab" + "\x60\x01";
  std::vector<std::byte> out(7);
  EXPECT_FALSE(lzf_decompress(text_bytes(packed), out));
  EXPECT_EQ(as_text(out), "abababa");
}

TEST(Lzf, long_back_references_use_an_extra_length_byte) {
  const std::string packed("\x00z\xe0\x0a\x00", 5);  // 7 + 10 + 2 copies of distance 1
  std::vector<std::byte> out(20);
  EXPECT_FALSE(lzf_decompress(text_bytes(packed), out));
  EXPECT_EQ(as_text(out), std::string(20, 'z'));
}

TEST(Lzf, damage_is_reported_with_its_offset) {
  std::vector<std::byte> out(7);
  EXPECT_EQ(lzf_decompress(text_bytes(std::string_view("\x20\x00", 2)), out), 0U);   // before start
  EXPECT_EQ(lzf_decompress(text_bytes("\x05"), out), 0U);                            // cut literal
  EXPECT_EQ(lzf_decompress(text_bytes(std::string_view("\x00z\xe0", 3)), out), 2U);  // cut length
  EXPECT_EQ(lzf_decompress(text_bytes(std::string_view("\x00z", 2)), out), 2U);      // too little
  EXPECT_EQ(lzf_decompress(text_bytes(std::string_view("\x00z\xe0\xff\x00", 5)), out), 2U);
}

}  // namespace
}  // namespace rali::io
