#include "rali/report/plot/axis.hpp"

#include <algorithm>
#include <cmath>

#include "rali/io/files/text.hpp"

namespace rali::report {

void Range::add(double value) {
  if (!std::isfinite(value)) return;
  low_ = any_ ? std::min(low_, value) : value;
  high_ = any_ ? std::max(high_, value) : value;
  any_ = true;
}

Range Range::widened(double share, double least) const {
  const double extra = std::max(share * width(), 0.5 * (least - width()));
  Range out;
  out.add(low() - std::max(extra, 0.0));
  out.add(high() + std::max(extra, 0.0));
  return out;
}

double tick_step(double width, std::size_t count) {
  if (!(width > 0.0) || !std::isfinite(width)) return 1.0;
  const double rough = width / static_cast<double>(std::max<std::size_t>(count, 1));
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

std::vector<double> ticks_of(const Range& range, std::size_t count) {
  std::vector<double> ticks;
  const double step = tick_step(range.width(), count);
  const double first = std::ceil(range.low() / step - 1e-9);
  for (std::size_t i = 0; i <= 4 * count + 4; ++i) {
    const double value = (first + static_cast<double>(i)) * step;
    if (value > range.high() + 1e-9 * step) break;
    ticks.push_back(value);
  }
  return ticks;
}

std::string tick_text(double value, double step) {
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(step) - 1e-9), 0.0, 9.0));
  return io::format_fixed(value, decimals);
}

}  // namespace rali::report
