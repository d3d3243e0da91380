#include "pipeline/lab/photographs/scan_readings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/ranges.h>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "calib/colour/colorimetry.hpp"
#include "pipeline/site/files/csv_table.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kFewestDirections = 20;
constexpr std::size_t kMostProblems = 40;
constexpr double kMostLight = 1e15;  // in any unit; sums of it stay finite
// A spectrum yields a colour if it covers most of what the eye sees, in steps that miss no absorption band.
constexpr double kFirstNeeded_nm = 440.0, kLastNeeded_nm = 660.0, kWidestStep_nm = 40.0;
// One reading's own error beside its scale, which all share.
constexpr double kReadingSigma = 0.01;

// Columns of the light, and the weight of each in X, Y and Z.
struct RadianceColumns {
  std::vector<std::size_t> columns;
  std::vector<glm::dvec3> weights;
  bool colours = true;
};

// "L552.5": 552.5.
std::optional<double> wavelength_of(const std::string& name) {
  if (!name.starts_with('L')) return std::nullopt;
  double nm = 0.0;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), nm);
  const bool whole = error == std::errc() && end == name.data() + name.size() && std::isfinite(nm);
  return whole ? std::optional(nm) : std::nullopt;
}

// A spectrum is a straight line between its wavelengths and level beyond them; its colour is linear in its values.
RadianceColumns of_spectrum(const std::map<double, std::size_t>& columns) {
  RadianceColumns light;
  std::vector<double> nm;
  for (const auto& [wavelength, column] : columns) {
    nm.push_back(wavelength);
    light.columns.push_back(column);
  }
  light.weights.assign(nm.size(), glm::dvec3{0.0});
  for (double at = kFirstVisible_nm; at <= kLastVisible_nm; at += 1.0) {
    const auto after = static_cast<std::size_t>(std::upper_bound(nm.begin(), nm.end(), at) - nm.begin());
    const auto eye = colour_matching(at);
    if (after == 0 || after == nm.size()) {
      light.weights[after == 0 ? 0 : after - 1] += eye;
      continue;
    }
    const double share = (at - nm[after - 1]) / (nm[after] - nm[after - 1]);
    light.weights[after - 1] += (1.0 - share) * eye;
    light.weights[after] += share * eye;
  }
  return light;
}

void check_wavelengths(const std::string& file, const std::map<double, std::size_t>& columns, Problems& problems) {
  if (columns.begin()->first > kFirstNeeded_nm || columns.rbegin()->first < kLastNeeded_nm)
    problems.add("{}:1: the wavelengths go from {} to {} nm: expected at least from {} to {}", file,
                 columns.begin()->first, columns.rbegin()->first, kFirstNeeded_nm, kLastNeeded_nm);
  for (auto next = columns.begin(), last = next++; next != columns.end(); last = next++)
    if (next->first - last->first > kWidestStep_nm)
      problems.add("{}:1: no wavelength between {} and {} nm: expected steps of at most {}", file, last->first,
                   next->first, kWidestStep_nm);
}

std::optional<RadianceColumns> light_columns(const std::string& file, const CsvTable& table, Problems& problems) {
  std::map<double, std::size_t> spectrum;
  for (std::size_t i = 0; i < table.names().size(); ++i)
    if (const auto nm = wavelength_of(table.names()[i])) {
      if (const auto [other, is_new] = spectrum.emplace(*nm, i); !is_new)
        problems.add("{}:1: column {} is {} nm again, as column {} is: expected each once", file, i + 1, *nm,
                     other->second + 1);
    }
  if (!spectrum.empty()) {
    check_wavelengths(file, spectrum, problems);
    return of_spectrum(spectrum);
  }
  const auto x = table.column("X"), y = table.column("Y"), z = table.column("Z");
  if (x && y && z) return RadianceColumns{{*x, *y, *z}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (x || y || z) {
    problems.add("{}:1: column {} is missing: expected all of X, Y and Z", file, !x ? "X" : !y ? "Y" : "Z");
    return std::nullopt;
  }
  // The white of sRGB, so that all three of a luminance come out alike.
  if (const auto luminance = table.column("luminance"))
    return RadianceColumns{{*luminance}, {srgb_to_xyz() * glm::dvec3(1.0)}, false};
  problems.add("{}:1: no light: expected columns L380 ... L780 (wavelengths in nm), or X, Y, Z, or luminance", file);
  return std::nullopt;
}

std::string note_of(const CsvTable& table, const std::vector<std::size_t>& used) {
  std::vector<std::string> left;
  for (std::size_t i = 0; i < table.names().size(); ++i)
    if (std::find(used.begin(), used.end(), i) == used.end()) left.push_back(table.names()[i]);
  return left.empty() ? ""
                      : fmt::format("not used: {} {}", left.size() == 1 ? "column" : "columns", fmt::join(left, ", "));
}

Fault told(const Problems& problems) {
  if (problems.lines().size() <= kMostProblems) return problems.fault();
  Problems first;
  for (std::size_t i = 0; i < kMostProblems; ++i) first.add("{}", problems.lines()[i]);
  first.add("... and {} more", problems.lines().size() - kMostProblems);
  return first.fault();
}

}  // namespace

Result<ScanReadings> read_scan_readings(const std::filesystem::path& path) {
  Problems problems;
  const std::string file = path.string();
  const auto table = CsvTable::read(path, problems);
  if (table.names().empty()) return fail(problems.fault());
  const auto azimuth = table.column("azimuth_deg"), elevation = table.column("elevation_deg");
  for (const auto& [column, name] : {std::pair{azimuth, "azimuth_deg"}, std::pair{elevation, "elevation_deg"}})
    if (!column) problems.add("{}:1: column {} is missing", file, name);
  const auto light = light_columns(file, table, problems);
  if (!azimuth || !elevation || !light) return fail(told(problems));

  ScanReadings scan;
  scan.colours = light->colours;
  auto used = light->columns;
  used.insert(used.end(), {*azimuth, *elevation});
  scan.note = note_of(table, used);
  const glm::dmat3 to_srgb = glm::inverse(srgb_to_xyz());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto az = table.number(row, *azimuth, -360.0, 360.0, problems);
    const auto el = table.number(row, *elevation, 0.0, 90.0, problems);
    glm::dvec3 xyz{0.0};
    bool whole = az && el;
    for (std::size_t i = 0; i < light->columns.size(); ++i) {
      const auto value = table.number(row, light->columns[i], 0.0, kMostLight, problems);
      whole = whole && value;
      if (value) xyz += *value * light->weights[i];
    }
    if (!whole) continue;
    SkyReading reading;
    reading.direction = direction_from(from_degrees(90.0 - *el), from_degrees(*az));
    reading.light = to_srgb * xyz;
    reading.sigma = glm::dvec3(kReadingSigma);
    if (glm::all(glm::greaterThan(reading.light, glm::dvec3(0.0))))
      scan.readings.push_back(reading);
    else
      problems.add("{}:{}: no light of a sky (linear sRGB {:.3g}, {:.3g}, {:.3g}): expected more than 0 of each", file,
                   table.line(row), reading.light.r, reading.light.g, reading.light.b);
  }
  if (problems.empty() && scan.readings.size() < kFewestDirections)
    problems.add("{}: {} directions: expected at least {}", file, scan.readings.size(), kFewestDirections);
  if (!problems.empty()) return fail(told(problems));
  return scan;
}

}  // namespace kasumi
