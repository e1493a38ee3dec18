#include "rali/io/files/graph_files.hpp"

#include <string_view>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::io {
namespace {

constexpr int kDecimals = 9;
// PyFactorGraph's names: capitals but L, its sign of a landmark.
constexpr std::string_view kLetters = "ABCDEFGHIJKMNOPQRSTUVWXYZ";

/// Upper triangle, row by row, with translation before rotation.
std::string upper_triangle(const geometry::Mat6& m) {
  std::string text;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      text += fmt::format(" {:.9e}", m((row + 3) % 6, (col + 3) % 6) + 0.0);
    }
  }
  return text;
}

Status add_line(AtomicFile& file, std::string line) {
  line += '\n';
  return file.write(std::string_view(line));
}

}  // namespace

std::string pyfg_name(KeyframeId id) {
  if (id.vehicle.value >= kLetters.size()) return {};
  return fmt::format("{}{}", kLetters[id.vehicle.value], id.seq);
}

Status write_g2o(const std::string& path, const GraphFile& graph) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  for (std::size_t i = 0; i < graph.vertices.size(); ++i) {
    const std::string pose = pose_text(graph.vertices[i].T, kDecimals, kDecimals);
    if (auto status = add_line(*file, fmt::format("VERTEX_SE3:QUAT {} {}", i, pose)); !status) {
      return status;
    }
  }
  for (const GraphEdge& edge : graph.edges) {
    RALI_ASSERT(edge.from < graph.vertices.size() && edge.to < graph.vertices.size());
    const std::string pose = pose_text(edge.T_from_to, kDecimals, kDecimals);
    auto status = add_line(*file, fmt::format("EDGE_SE3:QUAT {} {} {}{}", edge.from, edge.to, pose,
                                              upper_triangle(edge.information)));
    if (!status) return status;
  }
  return file->commit();
}

Status write_pyfg(const std::string& path, const GraphFile& graph) {
  std::vector<std::string> names;
  for (const GraphVertex& vertex : graph.vertices) {
    names.push_back(pyfg_name(vertex.id));
    if (names.back().empty()) {
      return fail(ErrorCode::kNoAnswer, path,
                  fmt::format("vehicle {} has no letter; a pyfg file names at most {}",
                              vertex.id.vehicle.value, kLetters.size()));
    }
  }
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const GraphVertex& v = graph.vertices[i];
    auto status = add_line(*file, fmt::format("VERTEX_SE3:QUAT {} {} {}", format_stamp(v.t),
                                              names[i], pose_text(v.T, kDecimals, kDecimals)));
    if (!status) return status;
  }
  for (const GraphEdge& edge : graph.edges) {
    RALI_ASSERT(edge.from < names.size() && edge.to < names.size());
    auto status = add_line(
        *file, fmt::format("EDGE_SE3:QUAT {} {} {} {}{}", format_stamp(edge.t), names[edge.from],
                           names[edge.to], pose_text(edge.T_from_to, kDecimals, kDecimals),
                           upper_triangle(edge.covariance)));
    if (!status) return status;
  }
  for (const GraphRange& range : graph.ranges) {
    RALI_ASSERT(range.from < names.size() && range.to < names.size());
    auto status =
        add_line(*file, fmt::format("EDGE_RANGE {} {} {} {} {:.9e}", format_stamp(range.t),
                                    names[range.from], names[range.to],
                                    format_fixed(range.range_m, 6), range.variance_m2));
    if (!status) return status;
  }
  return file->commit();
}

}  // namespace rali::io
