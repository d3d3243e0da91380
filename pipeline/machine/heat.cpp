#include "pipeline/machine/heat.hpp"

#include <algorithm>
#include <cstdlib>

#include "pipeline/machine/kernel_files.hpp"

namespace kasumi {

namespace {

constexpr double kColdest_celsius = -40.0, kHottest_celsius = 200.0;  // beyond: the sensor is off, or broken

// At "critical" the kernel switches the machine off; 10 degrees below that counts as too hot.
ThermalZone read_zone(const std::filesystem::path& folder, double celsius) {
  ThermalZone zone{line_of(folder / "type"), celsius};
  for (const auto& entry : entries_of(folder, "trip_point_")) {
    const auto name = entry.filename().string();
    if (!name.ends_with("_type")) continue;
    const auto millidegrees = number_of(folder / (name.substr(0, name.size() - 5) + "_temp"));
    if (!millidegrees || *millidegrees <= 0.0) continue;
    const auto kind = line_of(entry);
    if (kind == "critical") zone.hot_celsius = std::min(zone.hot_celsius, *millidegrees / 1000.0 - 10.0);
    if (kind == "passive" || kind == "hot") zone.warm_celsius = std::min(zone.warm_celsius, *millidegrees / 1000.0);
  }
  zone.warm_celsius = std::min(zone.warm_celsius, zone.hot_celsius - 5.0);
  return zone;
}

}  // namespace

std::vector<ThermalZone> read_thermal_zones(const std::filesystem::path& sys) {
  std::vector<ThermalZone> zones;
  for (const auto& folder : entries_of(sys / "class/thermal", "thermal_zone")) {
    const auto millidegrees = number_of(folder / "temp");
    if (!millidegrees) continue;
    const double celsius = *millidegrees / 1000.0;
    if (celsius > kColdest_celsius && celsius < kHottest_celsius) zones.push_back(read_zone(folder, celsius));
  }
  return zones;
}

std::optional<unsigned long> read_throttling_bits(const std::filesystem::path& sys) {
  const auto text = line_of(sys / "devices/platform/soc/soc:firmware/get_throttled");
  if (text.empty()) return std::nullopt;
  return std::strtoul(text.c_str(), nullptr, 16);
}

bool is_throttled(unsigned long bits) {
  constexpr unsigned long kThrottled = 1u << 2, kNearLimit = 1u << 3;
  return (bits & (kThrottled | kNearLimit)) != 0;
}

}  // namespace kasumi
