#include "rali/base/result.hpp"

namespace rali {

std::string Error::message() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (!text.empty() && text.back() != '.') text += '.';
  if (!remedy.empty()) text += ' ' + remedy;
  return text;
}

}  // namespace rali
