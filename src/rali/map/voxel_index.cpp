#include "rali/map/voxel_index.hpp"

#include <utility>

#include "rali/base/assert.hpp"

namespace rali::map {
namespace {

constexpr std::size_t kFirstSlots = 1024;
constexpr std::size_t kBytesPerSlot = sizeof(VoxelKey) + sizeof(std::uint32_t);

/// Finaliser of MurmurHash3 (public domain): neighbouring cubes must not share a probe sequence.
std::size_t mixed(VoxelKey key) {
  key ^= key >> 33;
  key *= 0xff51afd7ed558ccdULL;
  key ^= key >> 33;
  key *= 0xc4ceb9fe1a85ec53ULL;
  key ^= key >> 33;
  return static_cast<std::size_t>(key);
}

}  // namespace

VoxelIndex::VoxelIndex() : keys_(kFirstSlots, kNoVoxel), indices_(kFirstSlots, 0) {}

std::size_t VoxelIndex::slot_of(VoxelKey key) const {
  const std::size_t mask = keys_.size() - 1;
  std::size_t slot = mixed(key) & mask;
  while (keys_[slot] != key && keys_[slot] != kNoVoxel) slot = (slot + 1) & mask;
  return slot;
}

VoxelIndex::Slot VoxelIndex::insert(VoxelKey key) {
  RALI_DASSERT(key != kNoVoxel);
  std::size_t slot = slot_of(key);
  if (keys_[slot] == key) return {indices_[slot], false};
  if (is_full()) {
    grow();
    slot = slot_of(key);
  }
  RALI_ASSERT(size_ < 0xffffffffULL);
  keys_[slot] = key;
  indices_[slot] = static_cast<std::uint32_t>(size_++);
  return {indices_[slot], true};
}

std::optional<std::uint32_t> VoxelIndex::find(VoxelKey key) const {
  if (key == kNoVoxel) return std::nullopt;
  const std::size_t slot = slot_of(key);
  if (keys_[slot] != key) return std::nullopt;
  return indices_[slot];
}

std::size_t VoxelIndex::memory_bytes() const { return keys_.size() * kBytesPerSlot; }

std::size_t VoxelIndex::memory_bytes_at_next_insert() const {
  return memory_bytes() * (is_full() ? 3 : 1);  // the old table and one of twice its size
}

void VoxelIndex::grow() {
  std::vector<VoxelKey> keys(keys_.size() * 2, kNoVoxel);
  std::vector<std::uint32_t> indices(keys.size(), 0);
  keys_.swap(keys);
  indices_.swap(indices);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == kNoVoxel) continue;
    const std::size_t slot = slot_of(keys[i]);
    keys_[slot] = keys[i];
    indices_[slot] = indices[i];
  }
}

}  // namespace rali::map
