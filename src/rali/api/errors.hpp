#pragma once

#include <utility>

#include "rali/base/result.hpp"
#include "rali/error.hpp"

namespace rali::api {

/// Throws the public exception of this kind of error, with the same sentence.
[[noreturn]] void throw_error(const Error& error);

/// The value, or the exception.
template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw_error(result.error());
  return std::move(*result);
}

inline void check(const Status& status) {
  if (!status) throw_error(status.error());
}

}  // namespace rali::api
