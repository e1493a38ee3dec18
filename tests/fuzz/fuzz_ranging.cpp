// Ranges with any length, time, sigma and ends through all checks before an estimator uses them.
// Used ranges must have a finite, positive variance; an initialised landmark must be finite.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "rali/base/assert.hpp"
#include "rali/ranging/anchor_finder.hpp"
#include "rali/ranging/arrival_clock.hpp"
#include "rali/ranging/exchange_pairer.hpp"
#include "rali/ranging/range_link.hpp"
#include "rali/ranging/range_sanity.hpp"

namespace {

using namespace rali;

constexpr std::size_t kRecord = 16, kRangesMax = 600;

template <class T>
T get(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// All checks of one pair. The own antenna drives a zigzag.
class Judges {
 public:
  explicit Judges(const ranging::RangingSettings& s)
      : sanity_(s.limits, s.sanity), link_(s.gate, s.link), finder_(s.finder, 0.0, 0.1) {}

  void judge(const sensor::RangeSample& r, double predicted_m) {
    const bool sane = !sanity_.check(r.t, r.range_m, r.sigma_m, std::nan("")).has_value();
    const double sigma_m = r.sigma_m > 0.0 ? r.sigma_m : 0.1;
    const auto d =
        link_.decide({r.t, r.range_m - predicted_m, sigma_m * sigma_m + 0.01, sigma_m, sane});
    RALI_ASSERT(!d.use || (std::isfinite(d.gate.R_m2) && d.gate.R_m2 > 0.0));
    RALI_ASSERT(std::isfinite(d.widen_factor) && d.widen_factor >= 1.0);
    if (!sane) return;
    x_m_ += 0.3;
    ranging::FinderSample sample;
    sample.t = r.t;
    sample.p_odom_antenna_m = {x_m_, std::sin(x_m_), 0.0};
    sample.range_m = r.range_m;
    sample.sigma_m = sigma_m;
    const auto found = finder_.add(sample, 0.0, geometry::Vec3::UnitZ());
    RALI_ASSERT(!found || (found->p_odom_m.allFinite() && found->covariance_m2.allFinite()));
    if (found) finder_.reset();
  }

 private:
  ranging::RangeSanity sanity_;
  ranging::RangeLink link_;
  ranging::AnchorFinder finder_;
  double x_m_ = 0.0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ranging::RangingSettings settings;
  Judges judges(settings);
  ranging::ExchangePairer pairer(settings.exchange);
  ranging::ArrivalClock clock(settings.arrival);
  ranging::MillisecondCount count;
  std::vector<ranging::PairedRange> out;
  Time t = Time::from_s(1000.0);
  std::size_t added = 0;
  for (; size >= kRecord && added < kRangesMax; data += kRecord, size -= kRecord, ++added) {
    const std::span bytes(data, kRecord);
    t = t + Duration::from_s(1e-3 * get<std::int16_t>(bytes, 0));
    sensor::RangeSample r;
    r.t = clock.add(count.unwrap(get<std::uint32_t>(bytes, 12)), t);
    r.from = VehicleId{static_cast<std::uint16_t>(bytes[2] & 3U)};
    r.to = VehicleId{static_cast<std::uint16_t>(bytes[2] >> 2U & 3U)};
    r.from_antenna = bytes[2] >> 4U & 1U;
    r.range_m = static_cast<double>(get<float>(bytes, 4));
    r.sigma_m = static_cast<double>(get<float>(bytes, 8));
    RALI_ASSERT(r.t <= t + Duration::from_s(1e-6));
    pairer.add(r, out);
    pairer.release(t, out);
  }
  pairer.flush(out);
  RALI_ASSERT(out.size() <= 2 * added);
  for (const ranging::PairedRange& p : out) {
    if (!p.duplicate) judges.judge(p.sample, 5.0);
  }
  return 0;
}
