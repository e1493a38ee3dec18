#include "rali/sensor/lidar_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

// Elevations are the makers' design values; a unit's own calibration differs by 0.1 to 0.3 deg.
// Sources: user manuals (Velodyne VLP-16, VLP-32C, HDL-32E, HDL-64E S2; RoboSense RS-LiDAR-16,
// RS-LiDAR-32, RS-Helios-5515, RS-Helios-16P; Hesai PandarXT-16, XT-32, XT-32M2X, Pandar40P),
// the calibration the maker ships for PandarQT64, and beam_altitude_angles of real Ouster metadata.
namespace rali::sensor {
namespace {

constexpr float kDegPerRad = 180.0F / std::numbers::pi_v<float>;

/// N elevations from `first` to `last` in equal steps.
template <std::size_t N>
constexpr std::array<float, N> even(float first, float last) {
  std::array<float, N> angles{};
  for (std::size_t i = 0; i < N; ++i) {
    angles[i] = first + (last - first) * static_cast<float>(i) / static_cast<float>(N - 1);
  }
  return angles;
}

constexpr auto kPlusMinus15By2 = even<16>(-15.0F, 15.0F);

constexpr std::array<float, 32> kVlp32c = {
    -25.0F,  -15.639F, -11.31F, -8.843F, -7.254F, -6.148F, -5.333F, -4.667F,
    -4.0F,   -3.667F,  -3.333F, -3.0F,   -2.667F, -2.333F, -2.0F,   -1.667F,
    -1.333F, -1.0F,    -0.667F, -0.333F, 0.0F,    0.333F,  0.667F,  1.0F,
    1.333F,  1.667F,   2.333F,  3.333F,  4.667F,  7.0F,    10.333F, 15.0F};

constexpr auto kHdl32e = even<32>(-30.667F, 10.667F);

// Lower block of 32 in steps of 1/2 deg, upper one in steps of 1/3 deg.
constexpr std::array<float, 64> hdl64e() {
  std::array<float, 64> angles{};
  for (std::size_t i = 0; i < 32; ++i) {
    angles[i] = -24.333F + 0.5F * static_cast<float>(i);
    angles[32 + i] = -8.333F + static_cast<float>(i) / 3.0F;
  }
  return angles;
}

constexpr auto kHdl64e = hdl64e();

constexpr std::array<float, 32> kRs32 = {
    -25.0F,  -14.638F, -10.281F, -7.91F,  -6.407F, -5.407F, -4.667F, -4.333F,
    -4.0F,   -3.667F,  -3.333F,  -3.0F,   -2.667F, -2.333F, -2.0F,   -1.667F,
    -1.333F, -1.0F,    -0.667F,  -0.333F, 0.0F,    0.333F,  0.667F,  1.0F,
    1.333F,  1.667F,   2.333F,   3.333F,  4.667F,  7.0F,    10.333F, 15.0F};

constexpr std::array<float, 32> kHelios32 = {
    -55.0F, -52.0F, -49.0F, -46.0F, -43.0F, -40.0F, -37.0F, -34.0F, -31.0F, -28.0F, -25.0F,
    -22.0F, -19.0F, -16.0F, -13.0F, -10.0F, -8.0F,  -6.67F, -5.33F, -4.0F,  -2.67F, -1.33F,
    0.0F,   1.33F,  2.67F,  4.0F,   5.5F,   7.0F,   9.0F,   11.0F,  13.0F,  15.0F};

constexpr auto kXt32 = even<32>(-16.0F, 15.0F);
constexpr auto kXt32m = even<32>(-20.8F, 19.5F);

constexpr std::array<float, 64> kQt64 = {
    -52.121F, -49.785F, -47.577F, -45.477F, -43.465F, -41.528F, -39.653F, -37.831F,
    -36.055F, -34.32F,  -32.619F, -30.95F,  -29.308F, -27.69F,  -26.094F, -24.517F,
    -22.964F, -21.42F,  -19.889F, -18.372F, -16.865F, -15.368F, -13.88F,  -12.399F,
    -10.925F, -9.457F,  -7.994F,  -6.535F,  -5.079F,  -3.626F,  -2.175F,  -0.725F,
    0.725F,   2.175F,   3.626F,   5.079F,   6.534F,   7.993F,   9.456F,   10.923F,
    12.397F,  13.877F,  15.365F,  16.861F,  18.368F,  19.885F,  21.415F,  22.959F,
    24.524F,  26.101F,  27.697F,  29.315F,  30.957F,  32.627F,  34.328F,  36.064F,
    37.84F,   39.662F,  41.537F,  43.475F,  45.487F,  47.587F,  49.795F,  52.133F};

constexpr std::array<float, 40> kPandar40p = {
    -24.985F, -18.977F, -14.018F, -13.062F, -12.094F, -11.12F, -10.133F, -9.148F, -8.147F, -7.151F,
    -6.149F,  -5.814F,  -5.479F,  -5.145F,  -4.808F,  -4.473F, -4.138F,  -3.8F,   -3.463F, -3.128F,
    -2.788F,  -2.453F,  -2.116F,  -1.776F,  -1.439F,  -1.101F, -0.763F,  -0.425F, -0.088F, 0.249F,
    0.587F,   0.925F,   1.263F,   1.6F,     1.94F,    2.952F,  4.969F,   7.971F,  10.944F, 14.794F};

/// N elevations c0 + c1 u + c2 u^2 + c3 u^3 with u from -1 to 1 in equal steps.
template <std::size_t N>
constexpr std::array<float, N> curved(float c0, float c1, float c2, float c3) {
  std::array<float, N> angles{};
  for (std::size_t i = 0; i < N; ++i) {
    const float u = -1.0F + 2.0F * static_cast<float>(i) / static_cast<float>(N - 1);
    angles[i] = c0 + u * (c1 + u * (c2 + u * c3));
  }
  return angles;
}

// Ouster: cubics through the beam_altitude_angles of real units (OS0-128, OS1-128, OS1-64, OS2-32;
// residuals 0.21, 0.02, 0.04, 0.03 deg); the models with fewer beams span the same field of view.
constexpr auto kOs0_32 = curved<32>(-0.365F, 44.679F, 0.104F, 1.209F);
constexpr auto kOs0_64 = curved<64>(-0.365F, 44.679F, 0.104F, 1.209F);
constexpr auto kOs0_128 = curved<128>(-0.365F, 44.679F, 0.104F, 1.209F);
constexpr auto kOs1_16 = curved<16>(-0.125F, 16.3F, -0.022F, 0.262F);
constexpr auto kOs1_32 = curved<32>(-0.464F, 22.384F, 0.033F, -0.99F);
constexpr auto kOs1_64 = curved<64>(-0.125F, 16.3F, -0.022F, 0.262F);
constexpr auto kOs1_128 = curved<128>(-0.464F, 22.384F, 0.033F, -0.99F);
constexpr auto kOs2_32 = curved<32>(0.222F, 10.843F, -0.019F, -0.151F);
constexpr auto kOs2_64 = curved<64>(0.222F, 10.843F, -0.019F, -0.151F);
constexpr auto kOs2_128 = curved<128>(0.222F, 10.843F, -0.019F, -0.151F);

LidarModel spinning(std::string_view name, std::string_view maker,
                    std::span<const float> elevations_deg) {
  return {name, maker, elevations_deg,
          true, true,  static_cast<std::uint16_t>(elevations_deg.size())};
}

LidarModel solid(std::string_view name, std::string_view maker, std::uint16_t lines) {
  return {name, maker, {}, false, true, lines};
}

const std::array<LidarModel, 33>& table() {
  static const std::array<LidarModel, 33> models = {
      spinning("vlp16", "Velodyne VLP-16", kPlusMinus15By2),
      spinning("vlp32c", "Velodyne VLP-32C", kVlp32c),
      spinning("hdl32e", "Velodyne HDL-32E", kHdl32e),
      spinning("hdl64e", "Velodyne HDL-64E", kHdl64e),
      spinning("os0_32", "Ouster OS0-32", kOs0_32),
      spinning("os0_64", "Ouster OS0-64", kOs0_64),
      spinning("os0_128", "Ouster OS0-128", kOs0_128),
      spinning("os1_16", "Ouster OS1-16", kOs1_16),
      spinning("os1_32", "Ouster OS1-32", kOs1_32),
      spinning("os1_64", "Ouster OS1-64", kOs1_64),
      spinning("os1_128", "Ouster OS1-128", kOs1_128),
      spinning("os2_32", "Ouster OS2-32", kOs2_32),
      spinning("os2_64", "Ouster OS2-64", kOs2_64),
      spinning("os2_128", "Ouster OS2-128", kOs2_128),
      spinning("rs16", "RoboSense RS-LiDAR-16", kPlusMinus15By2),
      spinning("rs32", "RoboSense RS-LiDAR-32", kRs32),
      spinning("helios16", "RoboSense RS-Helios-16P", kPlusMinus15By2),
      spinning("helios32", "RoboSense RS-Helios-5515", kHelios32),
      spinning("helios", "RoboSense RS-Helios-5515", kHelios32),
      spinning("xt16", "Hesai PandarXT-16", kPlusMinus15By2),
      spinning("xt32", "Hesai PandarXT-32", kXt32),
      spinning("xt32m", "Hesai PandarXT-32M2X", kXt32m),
      spinning("qt64", "Hesai PandarQT64", kQt64),
      spinning("pandar40p", "Hesai Pandar40P", kPandar40p),
      solid("mid360", "Livox Mid-360", 4),
      solid("mid70", "Livox Mid-70", 1),
      solid("avia", "Livox Avia", 6),
      solid("horizon", "Livox Horizon", 6),
      solid("tele15", "Livox Tele-15", 6),
      solid("hap", "Livox HAP", 6),
      solid("rsm1", "RoboSense RS-LiDAR-M1", 5),
      solid("airy", "RoboSense Airy", 0),
      solid("generic", "any", 0)};
  return models;
}

/// Largest distance [deg] from each measured elevation to the model's nearest, infinite if two
/// measured ones share a partner. Both ascending.
float worst_match(std::span<const float> found_rad, std::span<const float> model_deg) {
  float worst = 0.0F;
  std::size_t next = 0;
  for (const float found : found_rad) {
    const float found_deg = found * kDegPerRad;
    while (next + 1 < model_deg.size() &&
           std::abs(model_deg[next + 1] - found_deg) <= std::abs(model_deg[next] - found_deg)) {
      ++next;
    }
    if (next >= model_deg.size()) return std::numeric_limits<float>::infinity();
    worst = std::max(worst, std::abs(model_deg[next] - found_deg));
    ++next;
  }
  return worst;
}

}  // namespace

std::span<const LidarModel> lidar_models() { return table(); }

const LidarModel* find_lidar_model(std::string_view name) {
  for (const LidarModel& model : table()) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

std::string lidar_model_names() {
  std::string names;
  for (const LidarModel& model : table()) {
    names += (names.empty() ? "" : ", ") + std::string(model.name);
  }
  return names;
}

std::size_t nearest_ring(std::span<const float> elevations_rad, float elevation_rad) {
  const auto above = std::lower_bound(elevations_rad.begin(), elevations_rad.end(), elevation_rad);
  if (above == elevations_rad.begin()) return 0;
  const auto index = static_cast<std::size_t>(above - elevations_rad.begin());
  if (above == elevations_rad.end()) return index - 1;
  return elevation_rad - elevations_rad[index - 1] < *above - elevation_rad ? index - 1 : index;
}

const LidarModel* identify_lidar(std::span<const float> elevations_rad) {
  constexpr float kToleranceDeg = 0.4F;
  const LidarModel* best = nullptr;
  float best_deg = kToleranceDeg;
  for (const LidarModel& model : table()) {
    const std::size_t rings = model.elevations_deg.size();
    // Models with the same angles (a shared design) cannot be distinguished: the first is returned.
    if (elevations_rad.size() > rings || elevations_rad.size() + rings / 8 < rings) continue;
    if (elevations_rad.empty()) continue;
    const float worst_deg = worst_match(elevations_rad, model.elevations_deg);
    // A match within half a ring spacing is no evidence.
    const float spacing_deg = (model.elevations_deg.back() - model.elevations_deg.front()) /
                              static_cast<float>(rings - 1);
    if (worst_deg < best_deg && worst_deg < 0.45F * spacing_deg) {
      best = &model;
      best_deg = worst_deg;
    }
  }
  return best;
}

}  // namespace rali::sensor
