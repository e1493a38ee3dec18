#include "rali/io/containers/file_kind.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "rali/io/containers/bag_format.hpp"
#include "rali/io/containers/codec.hpp"
#include "rali/io/containers/cursor.hpp"
#include "rali/io/containers/mcap_format.hpp"

namespace rali::io {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kSqliteMagic = "SQLite format 3\0"sv;
constexpr std::string_view kPackets = "Convert with the maker's driver to a bag or an MCAP.";
constexpr std::string_view kCloud = "A recording is a ROS 1 .bag, an MCAP or a rosbag2.";
constexpr std::string_view kScan =
    "If it is a scan, give the folder that holds all scans. A recording is a ROS 1 .bag, an MCAP "
    "or a rosbag2.";
constexpr std::string_view kUnpack = "Unpack it first.";

struct Signature {
  std::string_view start;
  std::string_view words;
  std::string_view remedy;
};

constexpr Signature kSignatures[] = {
    {"\xd4\xc3\xb2\xa1"sv, "raw network packets (pcap), not decoded clouds", kPackets},
    {"\xa1\xb2\xc3\xd4"sv, "raw network packets (pcap), not decoded clouds", kPackets},
    {"\x4d\x3c\xb2\xa1"sv, "raw network packets (pcap), not decoded clouds", kPackets},
    {"\xa1\xb2\x3c\x4d"sv, "raw network packets (pcap), not decoded clouds", kPackets},
    {"\x0a\x0d\x0d\x0a"sv, "raw network packets (pcapng), not decoded clouds", kPackets},
    {"# .PCD"sv, "a point cloud (PCD), not a recording", kScan},
    {"VERSION 0.7"sv, "a point cloud (PCD), not a recording", kScan},
    {"VERSION .7"sv, "a point cloud (PCD), not a recording", kScan},
    {"ply\n"sv, "a point cloud (PLY), not a recording", kScan},
    {"ply\r\n"sv, "a point cloud (PLY), not a recording", kScan},
    {"LASF"sv, "a point cloud (LAS), not a recording", kCloud},
    {"PK\x03\x04"sv, "a zip archive", kUnpack},
    {"\x1f\x8b"sv, "compressed with gzip", kUnpack},
    {"BZh"sv, "compressed with bzip2", kUnpack},
    {"\xfd"
     "7zXZ\0"sv,
     "compressed with xz", kUnpack},
    {"\x04\x22\x4d\x18"sv, "compressed with lz4", kUnpack},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7-Zip archive", kUnpack},
    {"Rar!"sv, "a RAR archive", kUnpack},
    {"\x89PNG"sv, "a picture (PNG)", kCloud},
    {"\xff\xd8\xff"sv, "a picture (JPEG)", kCloud},
    {"%PDF"sv, "a PDF document", kCloud},
    {"\x89HDF"sv, "an HDF5 file", kCloud},
    {"\x7f"
     "ELF"sv,
     "a program", kCloud},
    {"#ROSBAG V1"sv, "a ROS 1 bag of an old version (1.x)", "Convert it with rosbag fix."},
    {"#ROSBAG"sv, "a ROS 1 bag cut within its first line", "Nothing of it is left to read."},
};

bool is_text(std::string_view start) {
  return std::all_of(start.begin(), start.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 ? byte != 0x7F : c == '\n' || c == '\r' || c == '\t';
  });
}

KnownKind other(std::span<const std::byte> bytes) {
  const std::string_view start = text_of(bytes);
  for (const Signature& signature : kSignatures) {
    if (start.starts_with(signature.start)) {
      return {FileKind::kOther, std::string(signature.words), std::string(signature.remedy)};
    }
  }
  constexpr std::size_t kTarMark = 257;
  if (start.size() > kTarMark + 5 && start.substr(kTarMark, 5) == "ustar") {
    return {FileKind::kOther, "a tar archive", std::string(kUnpack)};
  }
  if (start.find_first_not_of('\0') == std::string_view::npos) {
    return {FileKind::kOther, "only zeros at its start: the recording never reached the disk",
            "Copy it again from the machine that recorded it."};
  }
  if (is_text(start)) return {FileKind::kOther, "text, not a recording", std::string(kCloud)};
  std::string hex;
  for (const std::byte b : bytes.first(std::min<std::size_t>(8, bytes.size()))) {
    hex += fmt::format(" {:02x}", std::to_integer<unsigned>(b));
  }
  return {FileKind::kOther, fmt::format("unknown kind of file (first bytes{})", hex),
          std::string(kCloud)};
}

}  // namespace

KnownKind kind_of(std::span<const std::byte> start) {
  const std::string_view text = text_of(start);
  if (start.empty()) return {FileKind::kOther, "empty file", "Copy it again, or record again."};
  if (text.starts_with(kBagMagic)) return {FileKind::kBag, {}, {}};
  if (text.starts_with(kMcapMagic)) return {FileKind::kMcap, {}, {}};
  if (text.starts_with(kSqliteMagic)) return {FileKind::kSqlite, {}, {}};
  if (is_zstd(start)) return {FileKind::kZstd, {}, {}};
  return other(start);
}

}  // namespace rali::io
