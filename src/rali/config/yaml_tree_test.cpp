#include "rali/config/yaml_tree.hpp"

#include <gtest/gtest.h>

namespace rali::config {
namespace {

std::string error_of(std::string_view text) {
  const Result<Node> tree = parse_yaml(text, "f.yaml");
  return tree ? "" : tree.error().message();
}

TEST(YamlTree, an_empty_text_is_an_empty_map) {
  for (const std::string_view text : {"", "\n", "# only a comment\n", "---\n"}) {
    const Result<Node> tree = parse_yaml(text, "f.yaml");
    ASSERT_TRUE(tree) << text;
    EXPECT_EQ(tree->kind, Node::Kind::kMap);
    EXPECT_TRUE(tree->children.empty());
  }
}

TEST(YamlTree, keys_and_values_store_their_line) {
  const Result<Node> tree = parse_yaml("a: 1\nb:\n  c: [x,\n   y]\n", "f.yaml");
  ASSERT_TRUE(tree);
  const Node* b = tree->find("b");
  ASSERT_NE(b, nullptr);
  EXPECT_EQ(b->key_where, "f.yaml:2");
  const Node* c = b->find("c");
  ASSERT_NE(c, nullptr);
  ASSERT_EQ(c->children.size(), 2U);
  EXPECT_EQ(c->children[1].where, "f.yaml:4");
  EXPECT_EQ(tree->find("c"), nullptr);
}

TEST(YamlTree, an_alias_stands_for_a_copy_of_its_value) {
  const Result<Node> tree = parse_yaml("a: &x {p: 1}\nb: *x\n", "f.yaml");
  ASSERT_TRUE(tree);
  ASSERT_NE(tree->find("b"), nullptr);
  ASSERT_NE(tree->find("b")->find("p"), nullptr);
  EXPECT_EQ(tree->find("b")->find("p")->text, "1");
}

TEST(YamlTree, an_alias_bomb_is_refused_before_it_grows) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 10; ++k) bomb += (k > 0 ? ", *a" : "*a") + std::to_string(i - 1);
    bomb += "]\n";
  }
  EXPECT_NE(error_of(bomb).find("more than 20000 values"), std::string::npos) << error_of(bomb);
}

TEST(YamlTree, deep_nesting_is_refused_in_both_styles) {
  EXPECT_EQ(error_of(std::string(100000, '[')).substr(0, 7), "f.yaml:");
  EXPECT_EQ(error_of("- " + std::string(40, '[') + std::string(40, ']')),
            "f.yaml:1: nested deeper than 32 levels.");
  EXPECT_EQ(error_of(std::string(100000, '{')).substr(0, 7), "f.yaml:");
  std::string block;
  for (int i = 0; i < 200; ++i) block += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_NE(error_of(block).find("nested deeper than 32 levels"), std::string::npos);
}

TEST(YamlTree, an_alias_of_itself_is_refused) {
  EXPECT_NE(error_of("a: &x [*x]\n"), "");
  EXPECT_NE(error_of("a: *nowhere\n"), "");
}

TEST(YamlTree, syntax_errors_name_their_line) {
  EXPECT_EQ(error_of("a: 1\nb: [1, 2\n").substr(0, 7), "f.yaml:");
  EXPECT_EQ(error_of("a: 1\n\tb: 2\n").substr(0, 9), "f.yaml:2:") << error_of("a: 1\n\tb: 2\n");
}

TEST(YamlTree, two_documents_are_refused) {
  EXPECT_NE(error_of("a: 1\n---\nb: 2\n").find("a second YAML document"), std::string::npos);
}

TEST(YamlTree, non_scalar_and_null_keys_are_refused) {
  EXPECT_NE(error_of("? [1, 2]\n: 3\n"), "");
  EXPECT_NE(error_of("? {a: 1}\n: 3\n"), "");
  EXPECT_NE(error_of("~: 3\n"), "");
}

TEST(YamlTree, binary_oversized_and_unreadable_input_is_refused) {
  EXPECT_EQ(error_of(std::string_view("a: 1\0b", 6)),
            "f.yaml:offset 4: a zero byte: this is no text file.");
  EXPECT_NE(error_of(std::string(kMaxYamlBytes + 1, ' ')).find("at most"), std::string::npos);
  EXPECT_FALSE(parse_yaml_file("/nowhere/f.yaml"));
  EXPECT_FALSE(parse_yaml_file("/"));
}

TEST(YamlTree, a_file_truncated_at_any_byte_parses_or_gives_an_error) {
  const std::string text =
      "schema: 1\nvehicles:\n  v1: {recording: 'a b', lidar: {range_m: [0.4, 1e2]}}\n"
      "  v2: &x\n    recording: \"q\\x41\"\n  v3: *x\npriors:\n  - {a: b}\n  - >\n    folded\n";
  for (std::size_t n = 0; n <= text.size(); ++n) {
    const Result<Node> tree = parse_yaml(std::string_view(text).substr(0, n), "f.yaml");
    if (!tree) {
      EXPECT_EQ(tree.error().message().substr(0, 6), "f.yaml");
    }
  }
}

TEST(YamlTree, numbers_with_trailing_or_invalid_characters_are_refused) {
  double value = 0.0;
  EXPECT_TRUE(parse_double("+1.5e-3", value));
  EXPECT_EQ(value, 1.5e-3);
  for (const std::string_view text :
       {"", "1,5", "0x10", "nan", "inf5", "1 ", " 1", "1e", "--1", "1.2.3"}) {
    EXPECT_FALSE(parse_double(text, value)) << text;
  }
  long long whole = 0;
  EXPECT_TRUE(parse_integer("-12", whole));
  EXPECT_EQ(whole, -12);
  for (const std::string_view text : {"", "1.0", "99999999999999999999", "0x1"}) {
    EXPECT_FALSE(parse_integer(text, whole)) << text;
  }
}

TEST(YamlTree, a_number_is_written_so_that_it_reads_back_exactly) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, 12345678.9, -0.0, 5e-324}) {
    double again = 0.0;
    ASSERT_TRUE(parse_double(yaml_number(value), again)) << yaml_number(value);
    EXPECT_EQ(again, value);
  }
}

}  // namespace
}  // namespace rali::config
