// How hot the machine is, as the kernel and a Raspberry Pi's firmware report it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/site/config/heat_governor.hpp"

namespace kasumi {

// Of `sys`/class/thermal; sensors that give no plausible temperature are left out. BLOCKS for as long as sensors take.
std::vector<ThermalZone> read_thermal_zones(const std::filesystem::path& sys);

// Bits of a Raspberry Pi's firmware: 0 the supply's voltage is too low, 1 the CPU frequency is capped, 2 throttled, 3
// near the temperature limit; the same 16 higher: since boot. Empty: another machine.
std::optional<unsigned long> read_throttling_bits(const std::filesystem::path& sys);
// Whether they say that it is slowed down now.
bool is_throttled(unsigned long bits);

}  // namespace kasumi
