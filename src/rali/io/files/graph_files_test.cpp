#include "rali/io/files/graph_files.hpp"

#include <gtest/gtest.h>

#include "rali/io/files/covariance_csv.hpp"
#include "rali/io/files/grid_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

GraphFile two_vertices() {
  GraphFile graph;
  GraphVertex a;
  a.t = Time::from_s(1.0);
  GraphVertex b;
  b.t = Time::from_s(2.5);
  b.id = {VehicleId{1}, 7};
  b.T.p = geometry::Vec3(1, 2, 3);
  graph.vertices = {a, b};
  GraphEdge edge;
  edge.t = b.t;
  edge.to = 1;
  edge.T_from_to = b.T;
  edge.information.diagonal() << 1, 2, 3, 4, 5, 6;  // rotation, then translation
  edge.information(0, 3) = edge.information(3, 0) = 7;
  edge.covariance = edge.information.diagonal().cwiseInverse().asDiagonal();
  graph.edges = {edge};
  graph.ranges = {{b.t, 0, 1, 3.741657, 0.01}};
  return graph;
}

TEST(GraphFiles, g2o_uses_se3_quat_tags_with_translation_before_rotation) {
  const TestFolder folder;
  ASSERT_TRUE(write_g2o(folder.path("graph.g2o"), two_vertices()));
  EXPECT_EQ(folder.read("graph.g2o"),
            "VERTEX_SE3:QUAT 0 0.000000000 0.000000000 0.000000000 "
            "0.000000000 0.000000000 0.000000000 1.000000000\n"
            "VERTEX_SE3:QUAT 1 1.000000000 2.000000000 3.000000000 "
            "0.000000000 0.000000000 0.000000000 1.000000000\n"
            "EDGE_SE3:QUAT 0 1 1.000000000 2.000000000 3.000000000 "
            "0.000000000 0.000000000 0.000000000 1.000000000 "
            "4.000000000e+00 0.000000000e+00 0.000000000e+00 7.000000000e+00 0.000000000e+00 "
            "0.000000000e+00 5.000000000e+00 0.000000000e+00 0.000000000e+00 0.000000000e+00 "
            "0.000000000e+00 6.000000000e+00 0.000000000e+00 0.000000000e+00 0.000000000e+00 "
            "1.000000000e+00 0.000000000e+00 0.000000000e+00 2.000000000e+00 0.000000000e+00 "
            "3.000000000e+00\n");
}

TEST(GraphFiles, pyfg_names_vehicles_by_letters_and_holds_ranges) {
  const TestFolder folder;
  ASSERT_TRUE(write_pyfg(folder.path("graph.pyfg"), two_vertices()));
  const std::string text = folder.read("graph.pyfg");
  EXPECT_TRUE(text.starts_with("VERTEX_SE3:QUAT 1.000000000 A0 0.000000000 ")) << text;
  EXPECT_NE(text.find("\nVERTEX_SE3:QUAT 2.500000000 B7 1.000000000 "), std::string::npos);
  EXPECT_NE(text.find("\nEDGE_SE3:QUAT 2.500000000 A0 B7 1.000000000 "), std::string::npos);
  EXPECT_NE(text.find(" 1.000000000 2.500000000e-01 "), std::string::npos) << "1/4 comes first";
  EXPECT_TRUE(text.ends_with("\nEDGE_RANGE 2.500000000 A0 B7 3.741657 1.000000000e-02\n")) << text;
}

TEST(GraphFiles, pyfg_names_skip_l_and_at_most_25_vehicles_fit) {
  for (std::uint16_t v = 0; v < 25; ++v) {
    const std::string name = pyfg_name({VehicleId{v}, 3});
    ASSERT_EQ(name.size(), 2U);
    EXPECT_NE(name.front(), 'L');
  }
  const TestFolder folder;
  GraphFile graph = two_vertices();
  graph.vertices[1].id.vehicle.value = 25;
  const auto status = write_pyfg(folder.path("a"), graph);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kNoAnswer);
  EXPECT_EQ(folder.files(), 0U);
}

TEST(GridFile, image_rows_start_at_the_largest_y) {
  const TestFolder folder;
  const GridCell cells[] = {GridCell::kFree,     GridCell::kOccupied, GridCell::kUnknown,
                            GridCell::kOccupied, GridCell::kFree,     GridCell::kFree};
  GridView grid;
  grid.width = 3;
  grid.height = 2;
  grid.origin_x_m = -1.5;
  grid.origin_y_m = 2.0;
  grid.cells = cells;
  ASSERT_TRUE(write_grid(folder.path("map_2d"), grid));
  EXPECT_EQ(folder.read("map_2d.pgm"), std::string("P5\n3 2\n255\n\x00\xfe\xfe\xfe\x00\xcd", 17));
  EXPECT_EQ(folder.read("map_2d.yaml"),
            "image: map_2d.pgm\nmode: trinary\nresolution: 0.050000\n"
            "origin: [-1.500000, 2.000000, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
            "free_thresh: 0.196\n");
}

TEST(CovarianceCsv, has_the_21_numbers_of_the_upper_triangle) {
  const TestFolder folder;
  auto writer = CovarianceWriter::create(folder.path("v1.cov.csv"));
  ASSERT_TRUE(writer);
  geometry::Mat6 cov = geometry::Mat6::Zero();
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) cov(r, c) = cov(c, r) = 10.0 * r + c;
  }
  ASSERT_TRUE(writer->add(Time::from_s(1.5), cov));
  ASSERT_TRUE(writer->finish());
  const std::string text = folder.read("v1.cov.csv");
  EXPECT_TRUE(text.starts_with("stamp_s,c00,c01,c02,c03,c04,c05,c11,c12,"));
  EXPECT_NE(text.find("\n1.500000000,0.000000e+00,1.000000e+00,2.000000e+00,"), std::string::npos);
  EXPECT_TRUE(text.ends_with(",4.400000e+01,4.500000e+01,5.500000e+01\n")) << text;
}

TEST(GraphFiles, written_g2o_is_read_back) {
  const TestFolder folder;
  GraphFile graph = two_vertices();
  graph.vertices[1].T.R = geometry::so3_exp({0.1, -0.2, 0.3});
  ASSERT_TRUE(write_g2o(folder.path("graph.g2o"), graph));
  const auto file = read_g2o(folder.path("graph.g2o"));
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->ids, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(file->placed, (std::vector<bool>{true, true}));
  EXPECT_FALSE(file->planar);
  EXPECT_LT((file->graph.vertices[1].T.R - graph.vertices[1].T.R).norm(), 1e-8);
  ASSERT_EQ(file->graph.edges.size(), 1U);
  EXPECT_EQ(file->graph.edges[0].T_from_to.p, geometry::Vec3(1, 2, 3));
  EXPECT_EQ(file->graph.edges[0].information, graph.edges[0].information);
}

TEST(GraphFiles, planar_g2o_is_lifted_to_3d_and_vertices_may_lack_poses) {
  const auto file = parse_g2o(
      "# a comment\nVERTEX_SE2 7 1 2 1.5707963267948966\nFIX 7\n"
      "EDGE_SE2 7 9 0.5 0 0.1 1 2 3 4 5 6\n",
      "x.g2o");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_TRUE(file->planar);
  EXPECT_EQ(file->placed, (std::vector<bool>{true, false}));
  EXPECT_NEAR(file->graph.vertices[0].T.R(1, 0), 1.0, 1e-12) << "x of the body is y of the map";
  const geometry::Mat6& I = file->graph.edges[0].information;
  EXPECT_EQ(I(3, 3), 1.0);  // x
  EXPECT_EQ(I(3, 4), 2.0);  // x, y
  EXPECT_EQ(I(3, 2), 3.0);  // x, yaw
  EXPECT_EQ(I(4, 4), 4.0);
  EXPECT_EQ(I(4, 2), 5.0);
  EXPECT_EQ(I(2, 2), 6.0);
  EXPECT_EQ(I(0, 0), 1e4);  // roll
  EXPECT_EQ(I(5, 5), 1e4);  // z
  EXPECT_EQ(I(0, 5), 0.0);
}

TEST(GraphFiles, damaged_g2o_is_refused_with_its_line) {
  const std::string good = "VERTEX_SE2 1 0 0 0\n";
  const std::pair<const char*, const char*> cases[] = {
      {"VERTEX_SE2 1 0 0 0\n", "x.g2o:2: vertex 1 is there twice"},
      {"VERTEX_SE2 2 0 0\n", "x.g2o:2: has too few numbers"},
      {"VERTEX_SE2 2 0 0 0 0\n", "x.g2o:2: has too many numbers"},
      {"VERTEX_SE2 2 0 nan 0\n", "is no finite number"},
      {"VERTEX_SE2 a 0 0 0\n", "is no number of a vertex"},
      {"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 0\n", "the quaternion has length 0, not 1"},
      {"EDGE_SE2 1 1 0 0 0 1 0 0 1 0 1\n", "an edge from a vertex to itself"},
      {"EDGE_RANGE 1 2 3\n", "is no tag of a pose graph"}};
  for (const auto& [line, message] : cases) {
    const auto file = parse_g2o(good + line, "x.g2o");
    ASSERT_FALSE(file) << line;
    EXPECT_NE(file.error().message().find(message), std::string::npos) << file.error().message();
  }
  EXPECT_FALSE(parse_g2o("", "x.g2o"));
}

TEST(GraphFiles, g2o_truncated_at_any_byte_gives_a_graph_or_an_error) {
  const std::string text = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\nEDGE_SE2 0 1 0.5 0 0.1 1 2 3 4 5 6\n";
  for (std::size_t n = 0; n < text.size(); ++n) {
    const auto file = parse_g2o(text.substr(0, n), "x.g2o");
    if (!file) continue;
    EXPECT_LE(file->ids.size(), 2U);
    EXPECT_EQ(file->ids.size(), file->graph.vertices.size());
  }
}

}  // namespace
}  // namespace rali::io
