#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace rali::map {

/// Grows without moving its elements: a map of gigabytes must not need twice its memory during a
/// reallocation.
template <class T>
class BlockVector {
 public:
  static constexpr std::size_t kBlock = std::size_t{1} << 14;

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] T& operator[](std::size_t i) { return blocks_[i / kBlock][i % kBlock]; }

  [[nodiscard]] const T& operator[](std::size_t i) const { return blocks_[i / kBlock][i % kBlock]; }

  void push_back(const T& value) {
    if (size_ == blocks_.size() * kBlock) blocks_.push_back(std::make_unique<T[]>(kBlock));
    (*this)[size_++] = value;
  }

  [[nodiscard]] std::size_t memory_bytes() const { return blocks_.size() * kBlock * sizeof(T); }

  [[nodiscard]] std::size_t memory_bytes_at_next_push() const {
    return memory_bytes() + (size_ == blocks_.size() * kBlock ? kBlock * sizeof(T) : 0);
  }

 private:
  std::vector<std::unique_ptr<T[]>> blocks_;
  std::size_t size_ = 0;
};

}  // namespace rali::map
