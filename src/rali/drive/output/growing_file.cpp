#include "rali/drive/output/growing_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace rali::drive {
namespace {

constexpr std::size_t kFlushBytes = 64 * 1024;

Status disk_error(const std::string& path, int code) {
  const char* remedy = code == ENOSPC ? "Free space or choose another folder with -o." : "";
  return fail(ErrorCode::kMachine, path, fmt::format("cannot be written: {}", std::strerror(code)),
              remedy);
}

}  // namespace

GrowingFile::~GrowingFile() {
  if (fd_ < 0) return;
  static_cast<void>(flush());
  ::close(fd_);
}

GrowingFile::GrowingFile(GrowingFile&& other) noexcept { *this = std::move(other); }

GrowingFile& GrowingFile::operator=(GrowingFile&& other) noexcept {
  if (this != &other) {
    std::swap(fd_, other.fd_);
    std::swap(path_, other.path_);
    std::swap(waiting_, other.waiting_);
    std::swap(size_, other.size_);
  }
  return *this;
}

Result<GrowingFile> GrowingFile::create(const std::string& path) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return tl::make_unexpected(disk_error(path, error.value()).error());
  GrowingFile file;
  file.path_ = path;
  file.fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.fd_ < 0) return tl::make_unexpected(disk_error(path, errno).error());
  return file;
}

Status GrowingFile::add(std::string_view lines) {
  waiting_ += lines;
  return waiting_.size() >= kFlushBytes ? flush() : Status{};
}

Status GrowingFile::flush() {
  if (fd_ < 0) return {};
  std::size_t done = 0;
  while (done < waiting_.size()) {
    const ssize_t n = ::write(fd_, waiting_.data() + done, waiting_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int code = n < 0 ? errno : ENOSPC;
      // Back to whole lines: half a line would be read as a wrong number.
      const std::size_t cut = waiting_.rfind('\n', done == 0 ? 0 : done - 1);
      size_ += cut == std::string::npos || done == 0 ? 0 : static_cast<std::int64_t>(cut + 1);
      const int truncated = ::ftruncate(fd_, size_);
      waiting_.clear();
      return disk_error(path_, truncated == 0 ? code : errno);
    }
    done += static_cast<std::size_t>(n);
  }
  size_ += static_cast<std::int64_t>(waiting_.size());
  waiting_.clear();
  return {};
}

Status GrowingFile::close() {
  if (fd_ < 0) return {};
  Status status = flush();
  if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS && status) {
    status = disk_error(path_, errno);
  }
  if (::close(std::exchange(fd_, -1)) != 0 && status) status = disk_error(path_, errno);
  return status;
}

}  // namespace rali::drive
