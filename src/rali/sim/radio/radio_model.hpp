#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "rali/base/rng.hpp"
#include "rali/base/settings.hpp"
#include "rali/sensor/range_sample.hpp"
#include "rali/sim/radio/uwb_model.hpp"

namespace rali::sim {

/// The data link between vehicles: a mesh radio at 2.4 GHz.
struct RadioOptions {
  double rate_hz = 1.0;              ///< readings of signal strength per second and pair
  double power_1m_dbm = -30.0;       ///< received power at 1 m
  double path_loss_exponent = 2.2;   ///< 2 is free space
  double wall_thickness_m = 0.15;    ///< of walls that the mesh has as single sheets
  double wall_loss_db = 3.0;         ///< per wall crossed
  double wall_loss_db_per_m = 15.0;  ///< and per metre of it
  double max_wall_loss_db = 45.0;    ///< upper limit: signals also travel around walls
  double body_loss_db = 3.0;         ///< of a vehicle or person in the line of sight
  double fading_db = 4.0;            ///< sd of slow fading
  double fading_time_s = 5.0;        ///< its correlation time
  double power_noise_db = 1.0;       ///< sd of one reading
  double sensitivity_dbm = -88.0;    ///< power at which half the packets are lost
  double loss_fraction = 0.005;      ///< of packets with a strong signal
  double data_rate_bps = 5e6;        ///< of one direction of a pair
  double delay_s = 0.008;            ///< of an empty packet
  double delay_jitter_s = 0.004;     ///< mean of the additional delay
  double max_queue_s = 2.0;          ///< a packet that would wait longer is dropped

  /// No loss, no noise, no delay but that of the data rate.
  [[nodiscard]] static RadioOptions ideal();

  template <class V>
  void visit(V& v) {
    v("rate_hz", rate_hz, 0.0, 100.0, "readings of signal strength per second and pair");
    v("power_1m_dbm", power_1m_dbm, -120.0, 30.0, "received power at 1 m");
    v("path_loss_exponent", path_loss_exponent, 1.0, 6.0, "2 is free space");
    v("wall_thickness_m", wall_thickness_m, 0.0, 2.0, "of walls that are single sheets");
    v("wall_loss_db", wall_loss_db, 0.0, 60.0, "loss per wall");
    v("wall_loss_db_per_m", wall_loss_db_per_m, 0.0, 500.0, "loss per metre of wall");
    v("max_wall_loss_db", max_wall_loss_db, 0.0, 300.0, "what goes around loses no more");
    v("body_loss_db", body_loss_db, 0.0, 60.0, "loss by a vehicle or person in the way");
    v("fading_db", fading_db, 0.0, 20.0, "sd of slow fading");
    v("fading_time_s", fading_time_s, 0.01, 1000.0, "correlation time of fading");
    v("power_noise_db", power_noise_db, 0.0, 20.0, "sd of one power reading");
    v("sensitivity_dbm", sensitivity_dbm, -200.0, 0.0, "power with half the packets lost");
    v("loss_fraction", loss_fraction, 0.0, 1.0, "of packets with a strong signal");
    v("data_rate_bps", data_rate_bps, 1.0, 1e12, "bits per second of one direction");
    v("delay_s", delay_s, 0.0, 60.0, "of an empty packet");
    v("delay_jitter_s", delay_jitter_s, 0.0, 60.0, "mean of what is added to the delay");
    v("max_queue_s", max_queue_s, 0.0, 3600.0, "packets that would wait longer are lost");
  }
};

/// Radio link between the vehicles of a fleet. Each pair has its own random streams.
class RadioModel {
 public:
  RadioModel(const RadioOptions& options, std::uint64_t seed) : options_(options), seed_(seed) {}

  /// Signal strength of `a` that the radio of `b` reports at time t; empty if `b` receives nothing
  /// (see loss_probability). Call in time order for each pair.
  [[nodiscard]] std::optional<sensor::RadioSample> measure(Time t, const RadioEnd& a,
                                                           const RadioEnd& b,
                                                           const RayCaster& world,
                                                           std::span<const RadioBody> bodies = {});

  /// Arrival time at `b` of a packet that `a` sends at time t: it waits for earlier packets, then
  /// takes its transmission time and a random delay. Empty if it is lost.
  [[nodiscard]] std::optional<Time> send(Time t, std::size_t bytes, const RadioEnd& a,
                                         const RadioEnd& b, const RayCaster& world,
                                         std::span<const RadioBody> bodies = {});

  /// Power without noise and fading [dBm].
  [[nodiscard]] double mean_power_dbm(const RadioEnd& a, const RadioEnd& b, const RayCaster& world,
                                      std::span<const RadioBody> bodies = {}) const;

  [[nodiscard]] const RadioOptions& options() const { return options_; }

 private:
  /// Fading is the same in both directions; queue and packet loss are not.
  struct Link {
    Link(std::uint64_t seed, const std::string& name);

    Rng fade, noise, loss, delay;
    Wandering fading;
    std::optional<Time> last;  ///< of `fading`
    double fading_sd = 0.0;    ///< value of `fading` at that time
    std::map<int, Time> free;  ///< by sender: end of transmission of its last packet
  };

  [[nodiscard]] Link& link_of(int a, int b);
  [[nodiscard]] double power_dbm(Link& link, Time t, const RadioEnd& a, const RadioEnd& b,
                                 const RayCaster& world, std::span<const RadioBody> bodies);

  RadioOptions options_;
  std::uint64_t seed_;
  std::map<std::pair<int, int>, Link> links_;
};

}  // namespace rali::sim
