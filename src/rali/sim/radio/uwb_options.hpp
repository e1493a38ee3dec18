#pragma once

#include "rali/base/settings.hpp"

namespace rali::sim {

/// Errors of ultra-wideband two-way ranging and of its signal strengths. The defaults are those of
/// a LinkTrack-like radio on small ground vehicles indoors; dw1000() is a bare DW1000 on a mast.
/// Sources of all numbers: docs/reference/simulator.md.
struct UwbOptions {
  double rate_hz = 20.0;        ///< exchanges per second and pair of antennas
  double max_range_m = 150.0;   ///< farther exchanges are lost
  double sigma_m = 0.03;        ///< sd of the white noise at short distance
  double sigma_per_m = 0.0005;  ///< times the distance, added in quadrature
  double slow_sigma_m = 0.035;  ///< sd of a slowly varying error
  double slow_time_s = 3.0;     ///< its correlation time

  double pair_bias_m = 0.05;       ///< mean over pairs of antennas of the constant bias
  double pair_bias_sd_m = 0.08;    ///< its sd over pairs
  double angle_bias_m = 0.03;      ///< rms over azimuth of each antenna's own pattern
  double far_bias_m = 0.0;         ///< bias that grows with distance towards this value
  double far_bias_scale_m = 16.0;  ///< distance at which 63 % of it is reached

  double wall_thickness_m = 0.15;    ///< of a wall that the mesh has as a single sheet
  double wall_index = 2.0;           ///< refractive index: thickness * (index - 1) is added
  double wall_loss_db = 2.0;         ///< per wall crossed
  double wall_loss_db_per_m = 25.0;  ///< and per metre of it
  double body_loss_db = 6.0;         ///< of a vehicle or person in the line of sight
  double body_delay_m = 0.05;        ///< additional path length around or through one

  double blocked_from_db = 3.0;   ///< obstacles of less loss only lengthen the path
  double blocked_full_db = 13.0;  ///< obstacles of this loss have the full effect of what follows
  double blocked_sigma_m = 0.10;  ///< additional white noise behind obstacles
  double blocked_burst_fraction = 0.6;  ///< of the time the first path is missed, if obstructed
  double blocked_burst_m = 0.6;         ///< mean of the error then added
  double clear_burst_fraction = 0.04;   ///< the same in line of sight: obstructed by own structure
  double clear_burst_m = 0.30;          ///< the same in line of sight
  double burst_time_s = 1.5;            ///< mean length of a burst

  double multipath_m = 0.05;  ///< error per reflection as strong and as long as the direct path
  double pulse_m = 0.35;      ///< longer reflections are separated from the direct path
  double reflection = 0.5;    ///< amplitude of a reflected path
  double outlier_fraction = 0.0005;  ///< of gross errors
  double outlier_m = 5.0;            ///< mean size of a gross error, either sign
  double loss_fraction = 0.02;       ///< of exchanges lost with a strong signal

  double power_1m_dbm = -52.0;      ///< received power at 1 m
  double path_loss_exponent = 2.0;  ///< 2 is free space
  double ceiling_dbm = -78.6;       ///< the reported power saturates here
  double sensitivity_dbm = -98.0;   ///< received power at which half the exchanges are lost
  double fading_db = 1.0;           ///< sd of slow fading
  double power_noise_db = 0.35;     ///< sd of one reading
  double first_path_gap_db = 0.8;   ///< first path below the total in line of sight
  double resolution_m = 0.001;      ///< step of the reported range

  double stamp_offset_s = 0.005;  ///< sd over vehicles of the constant stamp error
  double stamp_drift_ppm = 1.0;   ///< sd over vehicles of the drift
  double stamp_jitter_s = 0.001;  ///< sd of one stamp

  /// The same radio without any error except delays by obstructing walls.
  [[nodiscard]] static UwbOptions ideal();

  /// A DW1000 module without calibration, on a mast (UWB-dataset, docs/reference/simulator.md).
  [[nodiscard]] static UwbOptions dw1000();

  template <class V>
  void visit(V& v) {
    v("rate_hz", rate_hz, 0.01, 200.0, "exchanges per second and pair of antennas");
    v("max_range_m", max_range_m, 1.0, 2000.0, "farther exchanges are lost");
    v("sigma_m", sigma_m, 0.0, 5.0, "sd of the white noise at short distance");
    v("sigma_per_m", sigma_per_m, 0.0, 0.1, "sd per metre of distance, added in squares");
    v("slow_sigma_m", slow_sigma_m, 0.0, 5.0, "sd of an error that wanders");
    v("slow_time_s", slow_time_s, 0.01, 1000.0, "correlation time of the wandering error");
    v("pair_bias_m", pair_bias_m, -5.0, 5.0, "mean of the constant bias of pairs");
    v("pair_bias_sd_m", pair_bias_sd_m, 0.0, 5.0, "sd over pairs of the constant bias");
    v("angle_bias_m", angle_bias_m, 0.0, 1.0, "rms over azimuth of each antenna's bias");
    v("far_bias_m", far_bias_m, -2.0, 2.0, "bias reached at large distance");
    v("far_bias_scale_m", far_bias_scale_m, 0.1, 1000.0, "distance of 63 % of far_bias_m");
    v("wall_thickness_m", wall_thickness_m, 0.0, 2.0, "of walls that are single sheets");
    v("wall_index", wall_index, 1.0, 4.0, "refractive index of walls");
    v("wall_loss_db", wall_loss_db, 0.0, 60.0, "loss per wall");
    v("wall_loss_db_per_m", wall_loss_db_per_m, 0.0, 500.0, "loss per metre of wall");
    v("body_loss_db", body_loss_db, 0.0, 60.0, "loss by a vehicle or person in the way");
    v("body_delay_m", body_delay_m, 0.0, 1.0, "longer way by a vehicle or person in the way");
    v("blocked_from_db", blocked_from_db, 0.0, 100.0, "less loss only makes the way longer");
    v("blocked_full_db", blocked_full_db, 0.1, 200.0, "loss of obstacles with full effect");
    v("blocked_sigma_m", blocked_sigma_m, 0.0, 5.0, "additional noise behind walls");
    v("blocked_burst_fraction", blocked_burst_fraction, 0.0, 0.99, "of time, first path missed");
    v("blocked_burst_m", blocked_burst_m, 0.0, 20.0, "mean excess then, behind walls");
    v("clear_burst_fraction", clear_burst_fraction, 0.0, 0.99, "of time, own structure in the way");
    v("clear_burst_m", clear_burst_m, 0.0, 20.0, "mean excess then, in line of sight");
    v("burst_time_s", burst_time_s, 0.001, 100.0, "mean length of a burst");
    v("multipath_m", multipath_m, 0.0, 1.0, "error per reflection as strong as the first path");
    v("pulse_m", pulse_m, 0.01, 5.0, "reflections longer than this are told apart");
    v("reflection", reflection, 0.0, 1.0, "amplitude of a reflected path");
    v("outlier_fraction", outlier_fraction, 0.0, 1.0, "of gross errors");
    v("outlier_m", outlier_m, 0.0, 100.0, "mean size of a gross error");
    v("loss_fraction", loss_fraction, 0.0, 1.0, "of exchanges lost with a strong signal");
    v("power_1m_dbm", power_1m_dbm, -120.0, 30.0, "received power at 1 m");
    v("path_loss_exponent", path_loss_exponent, 1.0, 6.0, "2 is free space");
    v("ceiling_dbm", ceiling_dbm, -120.0, 60.0, "the reported power saturates here");
    v("sensitivity_dbm", sensitivity_dbm, -200.0, 0.0, "power with half the exchanges lost");
    v("fading_db", fading_db, 0.0, 20.0, "sd of slow fading");
    v("power_noise_db", power_noise_db, 0.0, 20.0, "sd of one power reading");
    v("first_path_gap_db", first_path_gap_db, 0.0, 20.0, "first path below the total, in sight");
    v("resolution_m", resolution_m, 0.0, 0.1, "step of the reported range, 0: none");
    v("stamp_offset_s", stamp_offset_s, 0.0, 10.0, "sd over vehicles of the stamps' offset");
    v("stamp_drift_ppm", stamp_drift_ppm, 0.0, 1000.0, "sd over vehicles of the stamps' drift");
    v("stamp_jitter_s", stamp_jitter_s, 0.0, 1.0, "sd of one stamp");
  }
};

}  // namespace rali::sim
