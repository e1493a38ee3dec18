#include "rali/io/files/stream_file.hpp"

#include <utility>

namespace rali::io {
namespace {

constexpr Duration kSyncEvery = Duration::from_ns(10'000'000'000);  // product.md, section 1

}  // namespace

Result<StreamFile> StreamFile::create(const std::string& path) {
  auto file = AtomicFile::create(path, OnAbandon::kKeep);
  if (!file) return tl::make_unexpected(file.error());
  return StreamFile(std::move(*file));
}

Status StreamFile::add(std::string_view text) { return file_.write(text); }

Status StreamFile::add(std::string_view text, Time t) {
  if (auto status = file_.write(text); !status) return status;
  // A clock that jumps, in either direction, must not delay the flush.
  const bool due = !has_time_ || t - synced_ >= kSyncEvery || synced_ - t >= kSyncEvery;
  if (!due) return {};
  has_time_ = true;
  synced_ = t;
  return file_.sync();
}

Status StreamFile::finish() {
  Status status = file_.commit();
  if (!status) file_.keep_whole_lines();
  return status;
}

}  // namespace rali::io
