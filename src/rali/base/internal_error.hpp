#pragma once

#include <stdexcept>

namespace rali {

/// A failed assertion; carries expression, file and line.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace rali
