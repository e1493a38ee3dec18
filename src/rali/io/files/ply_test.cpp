#include <algorithm>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"

namespace rali::io {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto view = text_bytes(text);
  return {view.begin(), view.end()};
}

std::string error_of(std::string_view text) {
  const auto cloud = parse_ply(bytes_of(text), "a.ply");
  return cloud ? std::string("no error") : cloud.error().message();
}

template <class T>
void append(std::string& out, T value, bool big) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (big) std::reverse(raw, raw + sizeof value);
  out.append(raw, sizeof value);
}

std::string header(std::string_view format) {
  return "ply\nformat " + std::string(format) +
         " 1.0\ncomment made by hand\nobj_info nothing\nelement camera 1\n"
         "property list uchar int things\nproperty double f\nelement vertex 2\nproperty float x\n"
         "property list ushort short near\nproperty uchar scalar_Intensity\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string binary_file(bool big) {
  std::string file = header(big ? "binary_big_endian" : "binary_little_endian");
  file += '\x02';
  append(file, 11, big);
  append(file, 12, big);
  append(file, 0.5, big);
  for (int i = 0; i < 2; ++i) {
    append(file, 1.5F + static_cast<float>(i), big);
    append(file, static_cast<std::uint16_t>(i), big);
    if (i == 1) append(file, std::int16_t{-1}, big);
    file += static_cast<char>(200 + i);
  }
  file += '\x01';
  append(file, 0, big);
  return file;
}

void expect_content(const Result<CloudFile>& cloud) {
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->size(), 2U);
  ASSERT_EQ(cloud->fields.size(), 2U);
  EXPECT_EQ(cloud->point_step, 5U);
  EXPECT_EQ(cloud->column(cloud->field("x")), (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(cloud->column(cloud->field("intensity")), (std::vector<double>{200, 201}));
}

TEST(Ply, all_encodings_give_the_same_vertices_between_other_elements) {
  expect_content(parse_ply(bytes_of(binary_file(false)), "a.ply"));
  expect_content(parse_ply(bytes_of(binary_file(true)), "a.ply"));
  expect_content(parse_ply(
      bytes_of(header("ascii") + "2 11 12 0.5\n1.5 0 200\n2.5 1 -1 201\n1 0\n"), "a.ply"));
}

TEST(Ply, headers_with_carriage_returns_are_read) {
  const auto cloud = parse_ply(bytes_of("ply\r\nformat ascii 1.0\r\nelement vertex 1\r\n"
                                        "property float x\r\nend_header\r\n7\r\n"),
                               "a.ply");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->column(0)[0], 7.0);
}

TEST(Ply, truncated_at_any_byte_before_the_last_vertex_is_an_error) {
  for (const bool big : {false, true}) {
    const std::string whole = binary_file(big);
    for (std::size_t n = 0; n + 5 < whole.size(); ++n) {
      EXPECT_FALSE(parse_ply(bytes_of(whole.substr(0, n)), "a.ply")) << n;
    }
  }
  EXPECT_EQ(error_of(binary_file(false).substr(0, binary_file(false).size() - 6)),
            "a.ply: is cut: 1 of 2 rows of element 'vertex' are there.");
}

TEST(Ply, changed_at_any_byte_never_crashes) {
  const std::string whole = binary_file(true);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    for (const char c : {'\x00', '\x7f', '\xff', '9', '\n'}) {
      std::string wrong = whole;
      wrong[n] = c;
      const auto cloud = parse_ply(bytes_of(wrong), "a.ply");
      if (!cloud) continue;
      EXPECT_EQ(cloud->data.size(), cloud->size() * cloud->point_step);
    }
  }
}

TEST(Ply, huge_counts_neither_hang_nor_allocate_memory) {
  const std::string begin = "ply\nformat binary_little_endian 1.0\nelement ";
  EXPECT_NE(error_of(begin + "a 9000000000000000000\nelement vertex 4000000000\nproperty uchar x\n"
                             "end_header\nabc")
                .find("3 of 4000000000"),
            std::string::npos);
  EXPECT_NE(error_of(begin + "a 9000000000000000000\nproperty double d\nelement vertex 1\n"
                             "property float x\nend_header\nabc")
                .find("is cut: 0 of 9000000000000000000"),
            std::string::npos);
  EXPECT_NE(error_of(begin + "vertex 9000000000000000000\nproperty float x\nend_header\nabc")
                .find("more than 4 GiB"),
            std::string::npos);
  EXPECT_NE(error_of(begin + "a 1\nproperty list int double d\nelement vertex 1\nproperty float x\n"
                             "end_header\n\xff\xff\xff\xff"
                             "12345678")
                .find("is cut"),
            std::string::npos);
}

TEST(Ply, errors_name_file_and_line) {
  EXPECT_EQ(
      error_of("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1\nq\n"),
      "a.ply:7: 'q' is no value for 'x'.");
  EXPECT_EQ(
      error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n\n1 2\n"),
      "a.ply:7: has more values than properties.");
  EXPECT_EQ(error_of("ply\nformat ascii 1.0\nelement vertex many\n"),
            "a.ply:3: element 'vertex' has no number but 'many'.");
  EXPECT_EQ(error_of("ply\nformat ascii 1.0\nproperty float x\n"),
            "a.ply:3: a property stands before the first element.");
  EXPECT_EQ(error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty flot x\n"),
            "a.ply:4: 'flot' is no type of PLY.");
  EXPECT_EQ(error_of("ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n"),
            "a.ply: has no element vertex.");
  EXPECT_EQ(error_of("ply\nelement vertex 1\nproperty float x\nend_header\n1\n"),
            "a.ply:4: the header has no format line.");
}

}  // namespace
}  // namespace rali::io
