#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>

#include "rali/base/finding.hpp"

namespace rali::inspect {

/// "0.03 %", "7.1 %", "100 %": a fraction for a sentence, never as a power of ten.
[[nodiscard]] inline std::string percent(double fraction) {
  const double hundredths = 100.0 * fraction;
  if (hundredths > 0.0 && hundredths < 0.01) return "below 0.01 %";
  return hundredths < 9.95 ? fmt::format("{:.2g} %", hundredths)
                           : fmt::format("{:.0f} %", hundredths);
}

/// A measured number and the limit it was compared with.
struct Measured {
  double value = 0.0, limit = 0.0;
};

/// The four texts of a finding.
struct Words {
  std::string text, effect, remedy;
};

[[nodiscard]] inline Finding make_finding(std::string id, Severity severity, std::string topic,
                                          Words words, Measured measured = {}) {
  Finding finding;
  finding.id = std::move(id);
  finding.severity = severity;
  finding.topic = std::move(topic);
  finding.text = std::move(words.text);
  finding.effect = std::move(words.effect);
  finding.remedy = std::move(words.remedy);
  finding.value = measured.value;
  finding.limit = measured.limit;
  return finding;
}

}  // namespace rali::inspect
