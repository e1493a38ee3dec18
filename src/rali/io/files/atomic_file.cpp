#include "rali/io/files/atomic_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/system_error.hpp"

namespace rali::io {
namespace {

// Combines many small writes into few system calls.
constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

/// Makes a rename survive power loss. Some file systems refuse fsync of a folder; this is ignored,
/// since the file itself is complete.
void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int fd = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY);
  if (fd < 0) return;
  (void)::fsync(fd);
  ::close(fd);
}

/// Bytes up to and including the last line end; 0 if there is none or the file cannot be read.
std::uint64_t end_of_whole_lines(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  constexpr std::streamoff kBlock = 1 << 16;
  std::vector<char> block(static_cast<std::size_t>(kBlock));
  for (std::streamoff end = file ? static_cast<std::streamoff>(file.tellg()) : 0; end > 0;) {
    const std::streamoff begin = std::max<std::streamoff>(0, end - kBlock);
    file.seekg(begin);
    if (!file.read(block.data(), end - begin)) return 0;
    for (std::streamoff i = end; i > begin; --i) {
      if (block[static_cast<std::size_t>(i - begin - 1)] == '\n') {
        return static_cast<std::uint64_t>(i);
      }
    }
    end = begin;
  }
  return 0;
}

}  // namespace

std::string temporary_path_of(const std::string& path) {
  const std::filesystem::path target(path);
  return (target.parent_path() / ("." + target.filename().string() + ".tmp")).string();
}

AtomicFile::AtomicFile(std::string path, std::string temporary, int fd, OnAbandon on_abandon)
    : path_(std::move(path)), temporary_(std::move(temporary)), fd_(fd), on_abandon_(on_abandon) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      fd_(std::exchange(other.fd_, -1)),
      on_abandon_(other.on_abandon_),
      buffer_(std::move(other.buffer_)),
      written_(other.written_),
      broken_(std::move(other.broken_)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  abandon();
  path_ = std::move(other.path_);
  temporary_ = std::move(other.temporary_);
  fd_ = std::exchange(other.fd_, -1);
  on_abandon_ = other.on_abandon_;
  buffer_ = std::move(other.buffer_);
  written_ = other.written_;
  broken_ = std::move(other.broken_);
  return *this;
}

AtomicFile::~AtomicFile() { abandon(); }

void AtomicFile::abandon() noexcept {
  if (fd_ < 0) return;
  if (on_abandon_ == OnAbandon::kKeep) (void)flush();
  ::close(fd_);
  fd_ = -1;
  if (on_abandon_ == OnAbandon::kRemove) ::unlink(temporary_.c_str());
}

tl::unexpected<Error> AtomicFile::failure(std::string_view doing, int error_number) const {
  const bool full = error_number == ENOSPC || error_number == EDQUOT;
  return fail(ErrorCode::kMachine, path_,
              fmt::format("{} failed: {}", doing, system_error_text(error_number)),
              full ? "Make room on the disk or choose another folder." : "");
}

tl::unexpected<Error> AtomicFile::broken(int error_number) {
  if (!broken_) broken_ = failure("writing", error_number).value();
  return tl::make_unexpected(*broken_);
}

Result<AtomicFile> AtomicFile::create(const std::string& path, OnAbandon on_abandon) {
  std::string temporary = temporary_path_of(path);
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) {
    return fail(ErrorCode::kMachine, path,
                fmt::format("cannot be created: {}", system_error_text(errno)));
  }
  return AtomicFile(path, std::move(temporary), fd, on_abandon);
}

Status AtomicFile::write_out(std::span<const std::byte> bytes) {
  RALI_ASSERT(fd_ >= 0);
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0) {
      if (errno == EINTR) continue;
      return broken(errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    written_ += static_cast<std::uint64_t>(n);
  }
  return {};
}

Status AtomicFile::flush() {
  const Status status = write_out(buffer_);
  buffer_.clear();
  return status;
}

Status AtomicFile::write(std::span<const std::byte> bytes) {
  RALI_ASSERT(fd_ >= 0);
  if (buffer_.size() + bytes.size() > kBufferBytes) {
    if (auto status = flush(); !status) return status;
  }
  if (bytes.size() >= kBufferBytes) return write_out(bytes);
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return {};
}

Status AtomicFile::write(std::string_view text) { return write(text_bytes(text)); }

Status AtomicFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  RALI_ASSERT(offset + bytes.size() <= size());
  if (auto status = flush(); !status) return status;
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0) {
      if (errno == EINTR) continue;
      return broken(errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return {};
}

Status AtomicFile::sync() {
  if (auto status = flush(); !status) return status;
  if (::fdatasync(fd_) != 0) return failure("writing to the disk", errno);
  return {};
}

void AtomicFile::keep_whole_lines() {
  if (fd_ < 0) return;
  buffer_.clear();
  const int fd = std::exchange(fd_, -1);
  const std::uint64_t end = end_of_whole_lines(temporary_);
  const bool kept = end > 0 && ::ftruncate(fd, static_cast<off_t>(end)) == 0 && ::fsync(fd) == 0;
  ::close(fd);
  if (kept && std::rename(temporary_.c_str(), path_.c_str()) == 0) return sync_folder_of(path_);
  ::unlink(temporary_.c_str());
}

Status AtomicFile::commit() {
  if (broken_) return tl::make_unexpected(*broken_);
  if (auto status = flush(); !status) return status;
  if (::fsync(fd_) != 0) return failure("writing to the disk", errno);
  if (::close(std::exchange(fd_, -1)) != 0) {
    const int error_number = errno;
    if (on_abandon_ == OnAbandon::kRemove) ::unlink(temporary_.c_str());
    return failure("closing", error_number);
  }
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const int error_number = errno;
    if (on_abandon_ == OnAbandon::kRemove) ::unlink(temporary_.c_str());
    return failure("renaming", error_number);
  }
  sync_folder_of(path_);
  return {};
}

Status write_file_atomic(const std::string& path, std::span<const std::byte> bytes) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  if (auto status = file->write(bytes); !status) return status;
  return file->commit();
}

Status write_file_atomic(const std::string& path, std::string_view text) {
  return write_file_atomic(path, text_bytes(text));
}

}  // namespace rali::io
