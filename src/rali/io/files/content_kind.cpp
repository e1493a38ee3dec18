#include "rali/io/files/content_kind.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "rali/io/files/input_file.hpp"

namespace rali::io {
namespace {

using namespace std::string_view_literals;

struct Magic {
  std::string_view bytes;
  std::string_view kind;
};

// At least three bytes: the numbers of a KITTI scan may begin with any two of them by chance.
constexpr std::array kMagics = {
    Magic{"#ROSBAG V"sv, "a ROS bag"},
    Magic{"\x89MCAP0\r\n"sv, "an MCAP recording"},
    Magic{"SQLite format 3\0"sv, "an SQLite database (rosbag2?)"},
    Magic{"\xd4\xc3\xb2\xa1"sv, "raw network packets (pcap)"},
    Magic{"\xa1\xb2\xc3\xd4"sv, "raw network packets (pcap)"},
    Magic{"\x4d\x3c\xb2\xa1"sv, "raw network packets (pcap)"},
    Magic{"\x0a\x0d\x0d\x0a"sv, "raw network packets (pcapng)"},
    Magic{"LASF"sv, "a LAS cloud"},
    Magic{"\x28\xb5\x2f\xfd"sv, "zstd compressed data"},
    Magic{"\x04\x22\x4d\x18"sv, "lz4 compressed data"},
    Magic{"\x1f\x8b\x08"sv, "gzip compressed data"},
    Magic{"BZh"sv, "bzip2 compressed data"},
    Magic{"PK\x03\x04"sv, "a zip archive"},
    Magic{"\x89PNG"sv, "a PNG image"},
    Magic{"\xff\xd8\xff"sv, "a JPEG image"},
    Magic{"\x93NUMPY"sv, "a NumPy array"},
    Magic{"\x89HDF"sv, "an HDF5 file"},
    Magic{"%PDF"sv, "a PDF document"},
    Magic{"\x7f"
          "ELF"sv,
          "a program"},
    Magic{"version https://git-lfs"sv, "a Git LFS pointer, not the file itself"}};

constexpr std::size_t kLookAt = 512;

std::string_view kind_by_magic(std::string_view head) {
  for (const Magic& magic : kMagics) {
    if (head.starts_with(magic.bytes)) return magic.kind;
  }
  return {};
}

bool is_text(std::string_view head) {
  return std::all_of(head.begin(), head.end(), [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u == '\n' || u == '\r' || u == '\t' || (u >= 32 && u != 127);
  });
}

}  // namespace

bool begins_las(std::span<const std::byte> head) { return as_text(head).starts_with("LASF"); }

bool begins_ply(std::span<const std::byte> head) {
  const std::string_view text = as_text(head);
  return text.starts_with("ply\n") || text.starts_with("ply\r") || text.starts_with("ply ");
}

bool begins_pcd(std::span<const std::byte> head) {
  const std::string_view text = as_text(head);
  return text.starts_with("# .PCD") || text.starts_with("VERSION ") || text.starts_with("FIELDS ");
}

bool has_known_kind(std::span<const std::byte> head) {
  const std::string_view text = as_text(head.first(std::min(head.size(), kLookAt)));
  return begins_pcd(head) || begins_ply(head) || !kind_by_magic(text).empty() || is_text(text);
}

std::string content_kind(std::span<const std::byte> head) {
  if (head.empty()) return "an empty file";
  if (begins_pcd(head)) return "a point cloud (PCD)";
  if (begins_ply(head)) return "a point cloud or mesh (PLY)";
  const std::string_view text = as_text(head.first(std::min(head.size(), kLookAt)));
  if (const std::string_view kind = kind_by_magic(text); !kind.empty()) return std::string(kind);
  if (std::all_of(text.begin(), text.end(), [](char c) { return c == 0; })) return "only zeros";
  return is_text(text) ? "text" : "binary data of unknown kind";
}

}  // namespace rali::io
