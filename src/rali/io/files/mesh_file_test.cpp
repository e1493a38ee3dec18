#include "rali/io/files/mesh_file.hpp"

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

using geometry::Vec3f;

double area(const MeshFile& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3f u = mesh.vertices[t[1]] - mesh.vertices[t[0]];
    const Vec3f v = mesh.vertices[t[2]] - mesh.vertices[t[0]];
    sum += 0.5 * static_cast<double>(u.cross(v).norm());
  }
  return sum;
}

constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                              {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};

Vec3f corner(int i) {
  return {static_cast<float>(i & 1), static_cast<float>((i >> 1) & 1),
          static_cast<float>((i >> 2) & 1)};
}

std::string number(float v) { return v == 0.0F ? "0" : "1"; }

std::string point(int i) {
  const Vec3f p = corner(i);
  return number(p.x()) + " " + number(p.y()) + " " + number(p.z());
}

std::string cube_obj() {
  std::string text = "# a cube\no thing\n";
  for (int i = 0; i < 8; ++i) text += "v " + point(i) + "\n";
  for (const auto& f : kFaces) {
    text += "f";
    for (const int v : f) text += " " + std::to_string(v + 1) + "/1/1";
    text += "\n";
  }
  return text;
}

std::string cube_ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) text += point(i) + "\n";
  for (const auto& f : kFaces) {
    text += "4";
    for (const int v : f) text += " " + std::to_string(v);
    text += "\n";
  }
  return text;
}

std::vector<std::array<int, 3>> cube_triangles() {
  std::vector<std::array<int, 3>> triangles;
  for (const auto& f : kFaces) {
    triangles.push_back({f[0], f[1], f[2]});
    triangles.push_back({f[0], f[2], f[3]});
  }
  return triangles;
}

std::string cube_stl_ascii() {
  std::string text = "solid cube\n";
  for (const auto& t : cube_triangles()) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const int v : t) text += "  vertex " + point(v) + "\n";
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid cube\n";
}

std::string cube_stl_binary() {
  std::string file(80, ' ');
  file.replace(0, 5, "solid");  // as some programs begin binary files
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    file.append(raw, sizeof value);
  };
  put(std::uint32_t{12});
  for (const auto& t : cube_triangles()) {
    for (int i = 0; i < 3; ++i) put(0.0F);
    for (const int v : t) {
      for (int axis = 0; axis < 3; ++axis) put(corner(v)[axis]);
    }
    put(std::uint16_t{0});
  }
  return file;
}

Result<MeshFile> parse(const std::string& file, const std::string& name) {
  return parse_mesh_file(text_bytes(file), name);
}

std::string error_of(const std::string& file, const std::string& name) {
  const auto mesh = parse(file, name);
  return mesh ? std::string("no error") : mesh.error().message();
}

struct Format {
  std::string name, file;
};

std::vector<Format> all_formats() {
  return {{"a.obj", cube_obj()},
          {"a.PLY", cube_ply()},
          {"a.stl", cube_stl_ascii()},
          {"b.STL", cube_stl_binary()}};
}

TEST(MeshFile, a_unit_cube_has_area_6_in_every_format) {
  for (const Format& format : all_formats()) {
    const auto mesh = parse(format.file, format.name);
    ASSERT_TRUE(mesh) << mesh.error().message();
    EXPECT_EQ(mesh->triangles.size(), 12U) << format.name;
    EXPECT_NEAR(area(*mesh), 6.0, 1e-6) << format.name;
  }
}

TEST(MeshFile, written_mesh_is_read_back_with_reflectivity) {
  const TestFolder folder;
  const auto cube = parse(cube_ply(), "a.ply");
  std::vector<float> reflectivity;
  for (int i = 0; i < 12; ++i) reflectivity.push_back(static_cast<float>(i) / 16.0F);
  for (const bool with : {true, false}) {
    const std::string path = folder.path("mesh.ply");
    ASSERT_TRUE(write_mesh_ply(path, cube->vertices, cube->triangles,
                               with ? reflectivity : std::vector<float>{}));
    const auto again = read_mesh_file(path);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->vertices, cube->vertices);
    EXPECT_EQ(again->triangles, cube->triangles);
    EXPECT_EQ(again->reflectivity, with ? reflectivity : std::vector<float>{});
  }
  EXPECT_FALSE(write_mesh_ply(folder.path("x.ply"), cube->vertices, cube->triangles, {{0.5F}}));
}

TEST(MeshFile, truncated_or_changed_at_any_byte_never_gives_an_invalid_index) {
  for (const Format& format : all_formats()) {
    for (std::size_t n = 0; n < format.file.size(); ++n) {
      std::string wrong = format.file.substr(0, n);
      for (const bool cut : {true, false}) {
        if (!cut) {
          wrong = format.file;
          wrong[n] = static_cast<char>(wrong[n] ^ 0x55);
        }
        const auto mesh = parse(wrong, format.name);
        if (!mesh) {
          EXPECT_FALSE(mesh.error().message().empty());
          continue;
        }
        for (const auto& t : mesh->triangles) {
          for (const std::uint32_t v : t) ASSERT_LT(v, mesh->vertices.size());
        }
      }
    }
  }
}

TEST(MeshFile, truncated_binary_files_are_reported) {
  EXPECT_NE(error_of(cube_stl_binary().substr(0, 300).replace(0, 5, "cube "), "a.stl")
                .find("says 12 triangles, but has 216 bytes"),
            std::string::npos);
  EXPECT_NE(error_of(cube_ply().substr(0, cube_ply().size() - 12), "a.ply").find("is cut"),
            std::string::npos);
}

TEST(MeshFile, meshes_without_triangles_are_refused) {
  EXPECT_EQ(error_of("v 0 0 0\nv 1 0 0\n", "a.obj"),
            "a.obj: the mesh has no triangles. Export surfaces, not points or lines.");
  EXPECT_NE(error_of("solid x\nendsolid x\n", "a.stl").find("no triangles"), std::string::npos);
  EXPECT_NE(error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                     "a.ply")
                .find("no triangles"),
            std::string::npos);
}

TEST(MeshFile, errors_name_file_and_line) {
  EXPECT_EQ(error_of("v 0 0 0\nv 1 q 0\n", "a.obj"), "a.obj:2: 'q' is no coordinate.");
  EXPECT_EQ(error_of("v 0 0 0\nf 1 2 3\n", "a.obj"),
            "a.obj:2: '2' names none of the 1 vertices so far.");
  EXPECT_EQ(error_of("v 0 0 0\nf 1 1\n", "a.obj"), "a.obj:2: a face has 2 corners.");
  EXPECT_EQ(error_of("solid\nouter loop\nvertex 0 0 0\nendloop\n", "a.stl"),
            "a.stl:4: a facet has three vertices.");
  EXPECT_EQ(error_of("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj"),
            "a.obj: vertex 0 has a coordinate that is no finite number.");
  EXPECT_EQ(error_of("x", "a.fbx"),
            "a.fbx: is no mesh by its name. Files end with .ply, .obj or .stl.");
  const auto missing = read_mesh_file("/nowhere/a.ply");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("/nowhere/a.ply"), std::string::npos);
}

TEST(MeshFile, a_reflectivity_outside_0_to_1_is_refused_with_its_triangle) {
  const auto with = [](const std::string& value) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
           "property float reflectivity\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.5\n"
           "3 0 2 1 " +
           value + "\n";
  };
  EXPECT_EQ(error_of(with("1"), "a.ply"), "no error");
  EXPECT_EQ(error_of(with("200"), "a.ply"),
            "a.ply: triangle 1 has reflectivity 200, not 0 to 1. Scale the property, or leave it "
            "out.");
  for (const char* value : {"nan", "-0.1", "1e30", "inf"}) {
    EXPECT_NE(error_of(with(value), "a.ply"), "no error") << value;
  }
}

TEST(MeshFile, negative_indices_of_obj_count_from_the_last_vertex) {
  const auto mesh = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", "a.obj");
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST(MeshFile, huge_counts_neither_hang_nor_allocate_memory) {
  const std::string begin = "ply\nformat binary_little_endian 1.0\nelement ";
  EXPECT_NE(
      error_of(begin + "vertex 9000000000000000000\nproperty float x\nend_header\nabc", "a.ply")
          .find("is cut"),
      std::string::npos);
  EXPECT_NE(error_of(begin + "face 1\nproperty list uint int vertex_indices\nend_header\n"
                             "\xff\xff\xff\xff",
                     "a.ply")
                .find("is cut"),
            std::string::npos);
}

}  // namespace
}  // namespace rali::io
