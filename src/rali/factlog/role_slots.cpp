#include "rali/factlog/role_slots.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "rali/base/crc32c.hpp"
#include "rali/factlog/bytes.hpp"

namespace rali::factlog {

namespace {

// magic u32, length of the content u32, counter u64, zero u32, checksum of all others u32, content.
constexpr std::uint32_t kMagic = 0x524F4C45U;
constexpr std::size_t kCrcAt = 20;

struct Slot {
  std::uint64_t counter = 0;
  Bytes content;
};

std::uint32_t checksum(std::span<const std::byte> slot, std::size_t content_bytes) {
  return crc32c(slot.subspan(kSlotHeadBytes, content_bytes), crc32c(slot.first(kCrcAt)));
}

Bytes encode_slot(std::uint64_t counter, std::span<const std::byte> content) {
  Bytes out;
  put(out, kMagic);
  put(out, static_cast<std::uint32_t>(content.size()));
  put(out, counter);
  put(out, std::uint32_t{0});
  put(out, crc32c(content, crc32c(out)));
  out.insert(out.end(), content.begin(), content.end());
  out.resize(kSlotBytes);
  return out;
}

std::optional<Slot> decode_slot(std::span<const std::byte> slot) {
  if (slot.size() < kSlotBytes || get<std::uint32_t>(slot, 0) != kMagic) return std::nullopt;
  const std::size_t bytes = get<std::uint32_t>(slot, 4);
  if (bytes > kSlotContentMax) return std::nullopt;
  if (get<std::uint32_t>(slot, kCrcAt) != checksum(slot, bytes)) return std::nullopt;
  const auto content = slot.subspan(kSlotHeadBytes, bytes);
  return Slot{get<std::uint64_t>(slot, 8), Bytes(content.begin(), content.end())};
}

bool is_unused(std::span<const std::byte> slot) {
  return std::all_of(slot.begin(), slot.end(), [](std::byte b) { return b == std::byte{0}; });
}

}  // namespace

void RoleSlots::take(std::span<const std::byte> slots) {
  std::size_t unused = 0, read = 0;
  bool first_unused = false;
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t begin = std::min(k * kSlotBytes, slots.size());
    const auto bytes = slots.subspan(begin, std::min(kSlotBytes, slots.size() - begin));
    std::optional<Slot> slot = decode_slot(bytes);
    if (!slot) {
      unused += is_unused(bytes) ? 1 : 0;
      first_unused = first_unused || (k == 0 && unused == 1);
      continue;
    }
    ++read;
    if (read > 1 && slot->counter < counter_) continue;
    counter_ = slot->counter;
    content_ = std::move(slot->content);
  }
  // The first save goes to slot 1: if slot 0 is unused, that save was interrupted.
  state_ = read > 0 ? State::kRead : first_unused ? State::kNew : State::kUnreadable;
  one_is_damaged_ = read == 1 && unused == 0;
}

Status RoleSlots::save(std::span<const std::byte> content) {
  if (content.size() > kSlotContentMax) {
    return fail(ErrorCode::kInput, "role slot",
                fmt::format("has room for {} bytes, not {}", kSlotContentMax, content.size()));
  }
  const std::uint64_t counter = counter_ + 1;
  if (auto status = write(counter % 2, encode_slot(counter, content)); !status) return status;
  counter_ = counter;
  content_.assign(content.begin(), content.end());
  state_ = State::kRead;
  return {};
}

Result<DiskSlots> DiskSlots::open(const std::string& folder, const std::string& name) {
  auto directory = File::open(folder, File::Mode::kFolder);
  if (!directory) return tl::make_unexpected(directory.error());
  auto file = File::open(folder + "/" + name, File::Mode::kCreate);
  if (!file) return tl::make_unexpected(file.error());
  const auto bytes = file->read(0, 2 * kSlotBytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  DiskSlots slots(std::move(*file));
  slots.take(*bytes);
  if (bytes->size() == 2 * kSlotBytes) return slots;
  const Bytes rest(2 * kSlotBytes - bytes->size());
  const auto written = slots.file_.write(bytes->size(), rest);
  if (!written) return tl::make_unexpected(written.error());
  if (*written == File::Written::kNoRoom) {
    return fail(ErrorCode::kMachine, slots.file_.path(), "could not be written: the disk is full",
                "Free some space.");
  }
  if (auto status = slots.file_.sync(); !status) return tl::make_unexpected(status.error());
  if (auto status = directory->sync(); !status) return tl::make_unexpected(status.error());
  return slots;
}

Status DiskSlots::write(std::size_t slot, std::span<const std::byte> bytes) {
  const auto written = file_.write(slot * kSlotBytes, bytes);
  if (!written) return tl::make_unexpected(written.error());
  if (*written == File::Written::kNoRoom) {
    return fail(ErrorCode::kMachine, file_.path(), "could not be written: the disk is full",
                "Free some space.");
  }
  return file_.sync();
}

Status MemorySlots::write(std::size_t slot, std::span<const std::byte> bytes) {
  std::copy(bytes.begin(), bytes.end(),
            bytes_.begin() + static_cast<std::ptrdiff_t>(slot * kSlotBytes));
  return {};
}

}  // namespace rali::factlog
