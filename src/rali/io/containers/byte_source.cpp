#include "rali/io/containers/byte_source.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rali/io/containers/cursor.hpp"
#include "rali/io/files/system_error.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kWindowBytes = 64 * 1024;

class FileBytes final : public ByteSource {
 public:
  FileBytes(int fd, std::uint64_t size, std::string name)
      : fd_(fd), size_(size), name_(std::move(name)) {}

  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  ~FileBytes() override { ::close(fd_); }

  std::uint64_t size() const override { return size_; }

  const std::string& name() const override { return name_; }

  Status read(std::uint64_t offset, std::span<std::byte> out) override {
    while (!out.empty()) {
      const ssize_t n = ::pread(fd_, out.data(), out.size(), static_cast<off_t>(offset));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return failed(offset, std::strerror(errno));
      if (n == 0) return failed(offset, "the file became shorter while it was read");
      out = out.subspan(static_cast<std::size_t>(n));
      offset += static_cast<std::uint64_t>(n);
    }
    return {};
  }

  std::uint64_t next_data(std::uint64_t offset) override {
    const off_t data = ::lseek(fd_, static_cast<off_t>(offset), SEEK_DATA);
    if (data >= 0) return static_cast<std::uint64_t>(data);
    return errno == ENXIO ? size_ : offset;  // other file systems do not report holes
  }

 private:
  tl::unexpected<Error> failed(std::uint64_t offset, const std::string& reason) const {
    return fail(ErrorCode::kMachine, name_ + ":offset " + std::to_string(offset),
                "cannot be read: " + reason, "Check the disk");
  }

  int fd_;
  std::uint64_t size_;
  std::string name_;
};

class MemoryBytes final : public ByteSource {
 public:
  MemoryBytes(std::vector<std::byte> bytes, std::string name)
      : bytes_(std::move(bytes)), name_(std::move(name)) {}

  std::uint64_t size() const override { return bytes_.size(); }

  const std::string& name() const override { return name_; }

  Status read(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset) {
      return fail(ErrorCode::kMachine, name_, "read beyond the end");
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  }

 private:
  std::vector<std::byte> bytes_;
  std::string name_;
};

}  // namespace

Result<std::shared_ptr<ByteSource>> open_file_bytes(const std::string& path, std::string name) {
  if (name.empty()) name = path;

  struct stat info {};

  // Checked before opening: opening a pipe would block until a writer opens it.
  if (::stat(path.c_str(), &info) != 0) {
    return fail(input_error_code(errno), path, "cannot be opened: " + system_error_text(errno));
  }
  if (!S_ISREG(info.st_mode)) return fail(ErrorCode::kInput, path, "is not a regular file");
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    return fail(input_error_code(errno), path, "cannot be opened: " + system_error_text(errno));
  }
  return std::make_shared<FileBytes>(fd, static_cast<std::uint64_t>(info.st_size), std::move(name));
}

std::shared_ptr<ByteSource> memory_bytes(std::vector<std::byte> bytes, std::string name) {
  return std::make_shared<MemoryBytes>(std::move(bytes), std::move(name));
}

Result<bool> starts_with(ByteSource& source, std::string_view text) {
  if (source.size() < text.size()) return false;
  std::vector<std::byte> start(text.size());
  if (const Status status = source.read(0, start); !status) {
    return tl::make_unexpected(status.error());
  }
  return text_of(start) == text;
}

Result<std::span<const std::byte>> ByteWindow::view(std::uint64_t offset, std::size_t n) {
  const std::uint64_t size = source_->size();
  if (offset >= size) return std::span<const std::byte>();
  n = static_cast<std::size_t>(std::min<std::uint64_t>(n, size - offset));
  if (offset < begin_ || offset - begin_ + n > filled_) {
    const std::size_t want =
        static_cast<std::size_t>(std::min<std::uint64_t>(std::max(n, kWindowBytes), size - offset));
    filled_ = 0;
    if (buffer_.size() < want) buffer_.resize(want);
    const Status status = source_->read(offset, std::span(buffer_).first(want));
    if (!status) return tl::make_unexpected(status.error());
    begin_ = offset;
    filled_ = want;
  }
  return std::span<const std::byte>(buffer_).subspan(static_cast<std::size_t>(offset - begin_), n);
}

}  // namespace rali::io
