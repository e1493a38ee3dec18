#pragma once

#include <filesystem>
#include <string>

#include <stdlib.h>

namespace rali::net {

/// A new folder that is removed at the end.
class FolderForTest {
 public:
  FolderForTest() {
    std::string name = (std::filesystem::temp_directory_path() / "rali_net_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) folder_ = name;
  }

  ~FolderForTest() {
    std::error_code error;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
  }

  FolderForTest(const FolderForTest&) = delete;
  FolderForTest& operator=(const FolderForTest&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace rali::net
