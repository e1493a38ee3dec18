#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "rali/config/apply.hpp"
#include "rali/config/text_of.hpp"

namespace rali::config {
namespace {

enum class Root { kSmallest, kNearest };
constexpr ChoiceNames<2> kRootNames{"smallest", "nearest"};

struct NoiseSettings {
  double sigma_m = 0.1;
  double gap_m = std::numeric_limits<double>::infinity();

  template <class V>
  void visit(V& v) {
    v("sigma_m", sigma_m, 0.01, 5.0, "noise");
    v("gap_m", gap_m, 0.0, std::numeric_limits<double>::infinity(), "gap | none");
  }
};

struct ToySettings {
  double voxel_m = 0.5;
  int samples_min = 5;
  std::size_t cells = 100;
  bool project = true;
  Root root = Root::kSmallest;
  std::array<double, 3> eta = {0.5, 0.2, 0.3};
  std::string kind = "free text";
  NoiseSettings noise;

  template <class V>
  void visit(V& v) {
    v("voxel_m", voxel_m, 0.01, 5.0, "side of a voxel [m]");
    v("samples_min", samples_min, 2, 100, "fewer: no range");
    v("cells", cells, 1, 1e9, "capacity");
    v("project", project, "drop the height");
    v.choice("root", root, kRootNames, "which root");
    v("eta", eta, 0.0, 1.0, "weights");
    v("kind", kind, "a word");
    v.group("noise", noise, "noise");
  }
};

/// Applies YAML text to a toy struct and returns the error sentence, or "".
std::string try_apply(ToySettings& toy, std::string_view text, Origins* origins = nullptr) {
  FieldList fields;
  collect_fields("", toy, fields);
  const Result<Node> tree = parse_yaml(text, "fleet.yaml");
  if (!tree) return tree.error().message();
  Origins unused;
  const Status status = apply_map(*tree, "", "", fields, origins != nullptr ? *origins : unused);
  return status ? "" : status.error().message();
}

std::string try_apply(std::string_view text) {
  ToySettings toy;
  return try_apply(toy, text);
}

TEST(Settings, every_type_is_loaded_and_its_line_recorded) {
  ToySettings toy;
  Origins origins;
  EXPECT_EQ(try_apply(toy,
                      "voxel_m: 0.3\nsamples_min: 7\ncells: 12\nproject: false\nroot: nearest\n"
                      "eta: [0.1, 0.2, 0.7]\nkind: other\nnoise:\n  sigma_m: 0.2\n  gap_m: .inf\n",
                      &origins),
            "");
  EXPECT_EQ(toy.voxel_m, 0.3);
  EXPECT_EQ(toy.samples_min, 7);
  EXPECT_EQ(toy.cells, 12U);
  EXPECT_FALSE(toy.project);
  EXPECT_EQ(toy.root, Root::kNearest);
  EXPECT_EQ(toy.eta[2], 0.7);
  EXPECT_EQ(toy.kind, "other");
  EXPECT_EQ(toy.noise.sigma_m, 0.2);
  EXPECT_EQ(origins.at("noise.sigma_m"), "fleet.yaml:9");
  EXPECT_EQ(origins.count("noise"), 0U);
}

TEST(Settings, an_unknown_key_is_refused_with_line_and_most_similar_key) {
  EXPECT_EQ(try_apply("project: true\nvoxel: 0.3\n"),
            "fleet.yaml:2: unknown key 'voxel'. Did you mean 'voxel_m'?");
  EXPECT_EQ(try_apply("porject: true\n"),
            "fleet.yaml:1: unknown key 'porject'. Did you mean 'project'?");
}

TEST(Settings, a_key_at_the_wrong_level_gets_the_correct_path) {
  EXPECT_EQ(try_apply("sigma_m: 0.3\n"),
            "fleet.yaml:1: unknown key 'sigma_m'. Did you mean 'noise.sigma_m'?");
}

TEST(Settings, an_unknown_key_without_a_similar_one_lists_the_allowed_keys) {
  EXPECT_EQ(try_apply("noise:\n  zzzzzz: 1\n"),
            "fleet.yaml:2: unknown key 'zzzzzz'. Known here: gap_m, sigma_m.");
}

TEST(Settings, values_out_of_bounds_are_refused_with_the_bounds) {
  EXPECT_EQ(try_apply("voxel_m: 0\n"), "fleet.yaml:1: voxel_m is 0; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("\nsamples_min: 101"),
            "fleet.yaml:2: samples_min is 101; allowed is 2 to 100, whole.");
  EXPECT_EQ(try_apply("voxel_m: .nan"), "fleet.yaml:1: voxel_m is .nan; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("voxel_m: .inf"), "fleet.yaml:1: voxel_m is .inf; allowed is 0.01 to 5.");
}

TEST(Settings, values_at_the_bounds_are_accepted) {
  EXPECT_EQ(try_apply("voxel_m: 0.01\nsamples_min: 100\n"), "");
}

TEST(Settings, wrong_types_are_refused) {
  EXPECT_EQ(try_apply("samples_min: 7.5"),
            "fleet.yaml:1: samples_min is 7.5; allowed is 2 to 100, whole.");
  EXPECT_EQ(try_apply("project: yes"), "fleet.yaml:1: project is yes; allowed is true or false.");
  EXPECT_EQ(try_apply("root: largest"),
            "fleet.yaml:1: root is largest; allowed is smallest, nearest.");
  EXPECT_EQ(try_apply("voxel_m: \"0.3\""),
            "fleet.yaml:1: voxel_m is \"0.3\"; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("voxel_m: 0,3"), "fleet.yaml:1: voxel_m is 0,3; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("voxel_m:"), "fleet.yaml:1: voxel_m is empty; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("voxel_m: {a: 1}"),
            "fleet.yaml:1: voxel_m is a group of keys; allowed is 0.01 to 5.");
  EXPECT_EQ(try_apply("eta: [1, 2]"),
            "fleet.yaml:1: eta is a list of 2; allowed is a list of 3 numbers, each 0 to 1.");
  EXPECT_EQ(try_apply("eta: [0, 1, 2]"),
            "fleet.yaml:1: eta is 2; allowed is a list of 3 numbers, each 0 to 1.");
  EXPECT_EQ(try_apply("noise: 3"),
            "fleet.yaml:1: noise must be a group of keys. Known here: gap_m, sigma_m.");
  EXPECT_EQ(try_apply("cells: -1"),
            "fleet.yaml:1: cells is -1; allowed is 1 to 1000000000, whole.");
}

TEST(Settings, a_key_given_twice_is_an_error) {
  EXPECT_EQ(
      try_apply("voxel_m: 0.3\nproject: true\nvoxel_m: 0.4\n"),
      "fleet.yaml:3: key 'voxel_m' is given twice (first at fleet.yaml:1). Remove one of them.");
}

TEST(Settings, command_line_assignments_are_checked_like_file_values) {
  ToySettings toy;
  FieldList fields;
  collect_fields("toy.", toy, fields);
  Origins origins;
  const auto set = [&](std::string_view assignment) -> std::string {
    const Result<Node> tree = parse_assignment(assignment);
    if (!tree) return tree.error().message();
    const Status status = apply_map(*tree, "", "", fields, origins);
    return status ? "" : status.error().message();
  };
  EXPECT_EQ(set("toy.noise.sigma_m=0.25"), "");
  EXPECT_EQ(toy.noise.sigma_m, 0.25);
  EXPECT_EQ(origins.at("toy.noise.sigma_m"), "command line");
  EXPECT_EQ(set("toy.eta=[0.3, 0.3, 0.4]"), "");
  EXPECT_EQ(set("toy.voxl_m=1"), "command line: unknown key 'toy.voxl_m'. Did you mean 'voxel_m'?");
  EXPECT_EQ(set("toy.voxel_m=100"), "command line: toy.voxel_m is 100; allowed is 0.01 to 5.");
  EXPECT_EQ(set("toy.voxel_m"),
            "command line: --set toy.voxel_m is not KEY=VALUE. Write for instance --set "
            "output.map_voxel_m=0.1.");
  EXPECT_EQ(set("=1").substr(0, 13), "command line:");
  EXPECT_EQ(set("toy..voxel_m=1"), "command line: 'toy..voxel_m' is no key.");
}

TEST(Settings, the_dump_loads_to_the_same_values_and_hash) {
  ToySettings toy;
  Origins origins;
  ASSERT_EQ(try_apply(toy, "voxel_m: 0.123456789012345678\nkind: \"a: 'b' # \\\\ \\\" \\n ~\"\n",
                      &origins),
            "");
  FieldList fields;
  collect_fields("", toy, fields);
  const std::string dumped = dump_yaml(fields, origins);
  EXPECT_NE(dumped.find("# fleet.yaml:1"), std::string::npos) << dumped;
  EXPECT_NE(dumped.find("# default"), std::string::npos);

  ToySettings again;
  ASSERT_EQ(try_apply(again, dumped), "") << dumped;
  EXPECT_EQ(again.voxel_m, toy.voxel_m);
  EXPECT_EQ(again.kind, toy.kind);
  FieldList fields_again;
  collect_fields("", again, fields_again);
  EXPECT_EQ(hash_fields(fields_again), hash_fields(fields));
}

TEST(Settings, the_hash_depends_on_nested_values) {
  ToySettings a, b;
  b.noise.gap_m = 7.0;
  FieldList of_a, of_b;
  collect_fields("", a, of_a);
  collect_fields("", b, of_b);
  EXPECT_NE(hash_fields(of_a), hash_fields(of_b));
}

TEST(Settings, strings_that_yaml_would_reinterpret_are_preserved_by_the_dump) {
  for (const std::string word :
       {"",   "~", "null", "true", "1e3", "- a", "a: b", "#x", "x # y", "*a", "&a",
        "!t", "@", "`",    "{",    "[",   "%",   "é",    "\t", "\x7f",  "'",  "\""}) {
    ToySettings toy;
    toy.kind = word;
    FieldList fields;
    collect_fields("", toy, fields);
    ToySettings again;
    again.kind = "?";
    ASSERT_EQ(try_apply(again, dump_yaml(fields, {})), "") << word;
    EXPECT_EQ(again.kind, word);
  }
}

TEST(Settings, the_manual_names_default_bounds_and_meaning_of_each_field) {
  ToySettings toy;
  FieldList fields;
  collect_fields("toy.", toy, fields);
  const std::string manual = manual_table(fields);
  EXPECT_NE(manual.find("| `toy.voxel_m` | `0.5` | 0.01 to 5 | side of a voxel [m] |"),
            std::string::npos)
      << manual;
  EXPECT_NE(manual.find("gap \\| none"), std::string::npos);
}

}  // namespace
}  // namespace rali::config
