#include "rali/io/files/input_file.hpp"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rali/io/files/system_error.hpp"

namespace rali::io {

InputFile::InputFile(std::string path, int fd, std::uint64_t size)
    : path_(std::move(path)), fd_(fd), size_(size) {}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)), size_(other.size_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  std::swap(size_, other.size_);
  return *this;
}

InputFile::~InputFile() {
  if (fd_ >= 0) ::close(fd_);
}

Result<InputFile> InputFile::open(const std::string& path) {
  // O_NONBLOCK: a named pipe in a folder of scans must not block the program forever.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    return fail(input_error_code(errno), path,
                fmt::format("cannot be read: {}", system_error_text(errno)));
  }
  InputFile file(path, fd, 0);
  struct stat info = {};
  if (::fstat(fd, &info) != 0) {
    return fail(ErrorCode::kMachine, path,
                fmt::format("cannot be examined: {}", system_error_text(errno)));
  }
  if (!S_ISREG(info.st_mode)) {
    return fail(ErrorCode::kInput, path,
                S_ISDIR(info.st_mode) ? "is a folder, not a file" : "is no regular file");
  }
  file.size_ = static_cast<std::uint64_t>(info.st_size);
  return file;
}

Result<std::size_t> InputFile::read(std::span<std::byte> buffer) {
  std::size_t done = 0;
  while (done < buffer.size()) {
    const ssize_t n = ::read(fd_, buffer.data() + done, buffer.size() - done);
    if (n == 0) break;
    if (n < 0) {
      if (errno == EINTR) continue;
      return fail(ErrorCode::kMachine, path_,
                  fmt::format("reading failed: {}", system_error_text(errno)));
    }
    done += static_cast<std::size_t>(n);
  }
  return done;
}

Result<std::vector<std::byte>> read_file(const std::string& path, std::uint64_t max_bytes) {
  auto file = InputFile::open(path);
  if (!file) return tl::make_unexpected(file.error());
  if (file->size() > max_bytes) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("has {} bytes; more than {} cannot be read at once", file->size(), max_bytes));
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(file->size()));
  const auto n = file->read(bytes);
  if (!n) return tl::make_unexpected(n.error());
  bytes.resize(*n);
  return bytes;
}

}  // namespace rali::io
