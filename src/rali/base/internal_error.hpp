#pragma once

#include <stdexcept>

namespace rali {

/// An assertion that did not hold; carries expression, file and line.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace rali
