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

TEST(GraphFiles, g2o_has_two_tags_only_and_translation_before_rotation) {
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

TEST(GraphFiles, no_vehicle_is_called_l_and_those_beyond_the_letters_are_refused) {
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

TEST(GridFile, picture_begins_with_the_largest_y) {
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

}  // namespace
}  // namespace rali::io
