#pragma once

#include <string>

#include "rali/base/settings.hpp"

namespace rali::sim {

/// Checks numbers against the ranges declared in visit().
struct RangeCheck {
  std::string bad;

  void operator()(const char* key, double value, double low, double high, const char*) {
    if (!(value >= low && value <= high) && bad.empty()) bad = key;
  }

  void operator()(const char*, bool, const char*) {}

  template <class Group>
  void group(const char*, Group& group, const char*) {
    group.visit(*this);
  }

  template <class E, std::size_t N>
  void choice(const char* key, E value, const ChoiceNames<N>&, const char*) {
    if (static_cast<std::size_t>(value) >= N && bad.empty()) bad = key;
  }
};

}  // namespace rali::sim
