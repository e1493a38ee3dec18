#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

TEST(CsvReader, finds_columns_by_name_in_any_order) {
  auto csv = CsvReader::from_text("b, a ,c\n1,2,3\n", "x.csv");
  ASSERT_TRUE(csv);
  ASSERT_TRUE(csv->next().value());
  EXPECT_EQ(csv->cell(csv->require("a").value()), "2");
  EXPECT_EQ(csv->cell(csv->column("b")), "1");
  EXPECT_EQ(csv->cell(csv->column("nothing")), "");
  EXPECT_EQ(csv->line(), 2U);
  EXPECT_FALSE(csv->next().value());
  EXPECT_FALSE(csv->next().value());
}

TEST(CsvReader, takes_quotes_comments_carriage_returns_and_byte_order_marks) {
  auto csv = CsvReader::from_text(
      "\xef\xbb\xbf# made by hand\r\na,b\r\n\r\n\"x, y\",\"say \"\"hi\"\"\"\r\n#no\r\n"
      "\"two\nlines\",2\r\nlast,",
      "x.csv");
  ASSERT_TRUE(csv) << csv.error().message();
  ASSERT_TRUE(csv->next().value());
  EXPECT_EQ(csv->cell(0), "x, y");
  EXPECT_EQ(csv->cell(1), "say \"hi\"");
  EXPECT_EQ(csv->line(), 4U);
  ASSERT_TRUE(csv->next().value());
  EXPECT_EQ(csv->cell(0), "two\nlines");
  EXPECT_EQ(csv->cell(1), "2");
  EXPECT_EQ(csv->line(), 6U);
  ASSERT_TRUE(csv->next().value());
  EXPECT_EQ(csv->where(), "x.csv:8");
  EXPECT_EQ(csv->cell(0), "last");
  EXPECT_TRUE(csv->complete());
  EXPECT_FALSE(csv->next().value());
}

TEST(CsvReader, reports_rows_with_a_wrong_number_of_cells) {
  auto csv = CsvReader::from_text("a,b\n1\n1,2,3\n1,2\n", "x.csv");
  ASSERT_TRUE(csv);
  ASSERT_TRUE(csv->next().value());
  EXPECT_FALSE(csv->complete());
  EXPECT_EQ(csv->cell(1), "");
  ASSERT_TRUE(csv->next().value());
  EXPECT_FALSE(csv->complete());
  ASSERT_TRUE(csv->next().value());
  EXPECT_TRUE(csv->complete());
}

TEST(CsvReader, names_the_error_of_an_invalid_file) {
  const auto error_of = [](std::string text) {
    const auto csv = CsvReader::from_text(std::move(text), "x.csv");
    return csv ? std::string("no error") : csv.error().message();
  };
  EXPECT_EQ(error_of(""), "x.csv: is an empty file.");
  EXPECT_EQ(error_of("# only\n\n"), "x.csv: has no header line.");
  EXPECT_EQ(error_of("a;b\n1;2\n"), "x.csv:1: the columns are not separated by commas.");
  EXPECT_EQ(error_of("a,b,a\n"), "x.csv:1: column 'a' stands twice.");
  EXPECT_EQ(error_of("#ROSBAG V2.0\n"), "x.csv: is a ROS bag, not a CSV table.");
  EXPECT_EQ(error_of(std::string("a,b\n\x01\x00", 6)),
            "x.csv: is binary data of unknown kind, not a CSV table.");
  EXPECT_EQ(error_of("\xff\xfe"
                     "a"),
            "x.csv: is text in UTF-16. Save it as UTF-8.");
  EXPECT_EQ(error_of("a,\"b\n1,2\n"), "x.csv:1: a cell that begins with a quote does not end.");
  EXPECT_EQ(error_of(std::string(2 << 20, 'a')), "x.csv:1: the line is longer than 1 MiB.");
  const auto csv = CsvReader::from_text("a,b\n", "x.csv");
  EXPECT_EQ(csv->require("stamp_s").error().message(),
            "x.csv: has no column 'stamp_s'; its columns are 'a', 'b'. The first line must name "
            "the columns.");
}

TEST(CsvReader, streams_files_larger_than_its_buffer) {
  const TestFolder folder;
  std::string text = "n,words\n";
  for (int i = 0; i < 40000; ++i) text += std::to_string(i) + ",some words to fill the row\n";
  auto csv = CsvReader::open(folder.write("big.csv", text));
  ASSERT_TRUE(csv);
  for (int i = 0; i < 40000; ++i) {
    ASSERT_TRUE(csv->next().value());
    ASSERT_EQ(csv->cell(0), std::to_string(i));
    ASSERT_EQ(csv->line(), static_cast<std::uint64_t>(i) + 2);
  }
  EXPECT_FALSE(csv->next().value());
}

TEST(CsvReader, reads_a_real_table_to_its_last_row) {
  RALI_NEEDS_DATA("uwb_pairs/outdoor_static.csv");
  auto csv = CsvReader::open(real_data("uwb_pairs/outdoor_static.csv"));
  ASSERT_TRUE(csv) << csv.error().message();
  const int range = csv->require("range_m").value();
  int rows = 0;
  while (csv->next().value()) {
    ASSERT_TRUE(csv->complete()) << csv->where();
    ASSERT_FALSE(csv->cell(range).empty()) << csv->where();
    ++rows;
  }
  EXPECT_EQ(rows, 36247);
}

TEST(CsvWriter, output_is_read_back_by_csv_reader) {
  const TestFolder folder;
  auto writer = CsvWriter::create(folder.path("a.csv"), {"stamp_s", "x", "n", "c", "text", "e"});
  ASSERT_TRUE(writer);
  CsvRow row;
  row.stamp(Time::from_ns(1500000001)).fixed(-0.00001, 3).integer(-7).scientific(12345.678, 6);
  row.text("a \"b\", c").empty();
  ASSERT_TRUE(writer->add(row, Time::from_s(1.5)));
  row.clear();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  row.stamp(Time::from_ns(-1)).fixed(nan, 3).integer(0).scientific(-nan, 2).text("#x").text("");
  ASSERT_TRUE(writer->add(row));
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(folder.read("a.csv"),
            "stamp_s,x,n,c,text,e\n1.500000001,0.000,-7,1.234568e+04,\"a \"\"b\"\", c\",\n"
            "-0.000000001,,0,,\"#x\",\n");
  auto reader = CsvReader::open(folder.path("a.csv"));
  ASSERT_TRUE(reader && reader->next().value());
  EXPECT_EQ(reader->cell(4), "a \"b\", c");
  EXPECT_TRUE(reader->complete());
}

}  // namespace
}  // namespace rali::io
