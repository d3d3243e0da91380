#include "calib/foreign_keys.hpp"

#include <array>
#include <map>
#include <vector>

namespace kasumi {
namespace {

// Of a fixture's description, and of a kiosk's configuration.
constexpr std::array kRoot{"calibration", "format", "name",    "description", "licence",   "provenance", "start_utc",
                           "site",        "sky",    "scene",   "object",      "landmarks", "display",    "still",
                           "words",       "clock",  "opening", "check",       "ladder",    "state",      "heat",
                           "snapshot",    "era",    "cards",   "content",     "visitor"};

// Keys that the readers of site, camera and landmark contrast leave to others.
const std::map<std::string_view, std::vector<std::string_view>>& shared_tables() {
  static const std::map<std::string_view, std::vector<std::string_view>> kTables{
      {"site",
       {"ground_albedo", "cloud_base_m", "fog", "sky_model", "haze_blur_px", "aod_550", "angstrom_exponent",
        "aerosol"}},
      {"sky", {"camera"}},
      {"scene",
       {"camera", "point_spread_px", "sharpening", "saturation", "tone_exponent", "shared_chroma", "jpeg_blocks",
        "noise", "depth_map", "people_in_front", "depth_step_m", "depth_no_data", "depth_sky_beyond_m", "depth_channel",
        "depth_inverse_scale", "depth_inverse_offset"}},
      {"landmarks", {"name", "latitude_deg", "longitude_deg", "altitude_m"}}};
  return kTables;
}

}  // namespace

void ignore_keys_of_others(const ConfigTable& root, const std::set<std::string_view>& own) {
  for (const auto& [name, keys] : shared_tables()) {
    if (!own.contains(name) || !root.has(name)) continue;
    const auto tables = name == "landmarks" ? root.tables(name) : std::vector{root.table(name)};
    for (const auto& table : tables)
      for (const auto key : keys) table.ignore(key);
  }
}

void ignore_what_others_read(const ConfigTable& root, const std::set<std::string_view>& own) {
  for (const char* key : kRoot)
    if (!own.contains(key)) root.ignore(key);
  ignore_keys_of_others(root, own);
}

}  // namespace kasumi
