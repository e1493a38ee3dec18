#pragma once

#include <string>
#include <utility>

#include "rali/base/finding.hpp"

namespace rali {

/// A Finding without a period of time and without a measured value.
[[nodiscard]] inline Finding finding_of(std::string id, Severity severity, std::string text,
                                        std::string effect, std::string remedy = {}) {
  Finding finding;
  finding.id = std::move(id);
  finding.severity = severity;
  finding.text = std::move(text);
  finding.effect = std::move(effect);
  finding.remedy = std::move(remedy);
  return finding;
}

}  // namespace rali
