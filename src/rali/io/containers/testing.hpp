#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

#include "rali/io/containers/cursor.hpp"
#include "rali/io/message_source.hpp"

// Shared helpers of the reader tests. Only tests include this.
namespace rali::io::testing {

/// One message returned by a reader, copied.
struct Got {
  std::string topic;
  std::int64_t t_ns = 0;
  std::string data;
  bool operator==(const Got&) const = default;
};

struct Drained {
  std::vector<Got> messages;
  SourceHealth health;
  std::string error;  ///< empty if the reading ended normally
};

inline Drained drain(MessageSource& source) {
  Drained out;
  RawMessage message;
  while (true) {
    const auto more = source.next(message);
    if (!more) {
      out.error = more.error().message();
      break;
    }
    if (!*more) break;
    out.messages.push_back({source.topics().at(message.topic).name, message.t_record.ns,
                            std::string(text_of(message.data))});
  }
  out.health = source.health();
  return out;
}

/// The texts of all findings, one a line.
inline std::string texts(const SourceHealth& health) {
  std::string out;
  for (const Finding& finding : health.findings) out += finding.text + '\n';
  return out;
}

inline std::vector<std::byte> copy(std::string_view text) {
  const auto bytes = bytes_of(text);
  return {bytes.begin(), bytes.end()};
}

inline std::vector<std::byte> first(const std::vector<std::byte>& bytes, std::size_t n) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)};
}

/// True if `some` are the first messages of `all`.
inline bool is_prefix(const std::vector<Got>& some, const std::vector<Got>& all) {
  return some.size() <= all.size() &&
         std::equal(some.begin(), some.end(), all.begin(),
                    all.begin() + static_cast<std::ptrdiff_t>(some.size()));
}

/// A temporary folder of one test, removed at its end.
struct ScratchFolder {
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "rali-test-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path = name;
  }

  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  ~ScratchFolder() {
    std::error_code error;
    if (!path.empty()) std::filesystem::remove_all(path, error);
  }

  std::string path;
};

inline void write_file(const std::string& path, const std::vector<std::byte>& bytes) {
  const std::string_view text = text_of(bytes);
  std::ofstream(path, std::ios::binary)
      .write(text.data(), static_cast<std::streamsize>(text.size()));
}

inline std::vector<std::byte> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return copy(std::string(std::istreambuf_iterator<char>(file), {}));
}

}  // namespace rali::io::testing
