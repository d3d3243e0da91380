#include "pipeline/lab/prove/air_by_others.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/utc_text.hpp"
#include "pipeline/site/files/csv_table.hpp"

namespace kasumi {
namespace {

constexpr auto kNear = std::chrono::minutes(30);
constexpr double kUsualSigma = 0.2;  // of an extinction whose table gives none
constexpr double kThickest_per_m = 1.0;

}  // namespace

std::vector<AirByOthers> air_by_landmarks(const ProofInputs& scene) {
  const LandmarkWatch watch(scene.camera, scene.altitude_m, scene.others);
  std::vector<std::vector<ContrastReading>> readings;
  for (const auto& view : scene.views) readings.push_back(view.readings);
  const auto found = watch.estimate_all(readings);
  std::vector<AirByOthers> airs(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const auto& channel = found[i].channels[static_cast<std::size_t>(c)];
      if (channel.kind == ExtinctionKind::nothing) airs[i].unknown = channel.reason;
      airs[i].per_m[c] = channel.per_m;
      // Of a bound the value is the likeliest within it, and half the way to its end the sigma.
      airs[i].sigma_per_m[c] =
          channel.kind == ExtinctionKind::value
              ? channel.sigma_per_m
              : std::max(channel.sigma_per_m, 0.25 * (channel.highest_per_m - channel.lowest_per_m));
    }
  }
  return airs;
}

Result<std::vector<AirByOthers>> air_by_table(const ProofInputs& scene, const std::filesystem::path& file) {
  Problems problems;
  const auto table = CsvTable::read(file, problems);
  const auto utc = table.column("utc"), green = table.column("extinction_g_per_m");
  const auto red = table.column("extinction_r_per_m"), blue = table.column("extinction_b_per_m");
  const auto sigma = table.column("extinction_sigma_per_m");
  if (problems.empty() && (!utc || !green))
    problems.add("{}: expected columns utc and extinction_g_per_m", file.string());
  if (!problems.empty()) return fail(problems.fault());
  std::vector<std::pair<Utc, AirByOthers>> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto time = parse_utc(table.text(row, *utc));
    if (!time)
      problems.add("{}:{}: utc '{}': expected a time like 2018-01-29T11:09:20Z", file.string(), table.line(row),
                   table.text(row, *utc));
    const auto read = [&](const std::optional<std::size_t>& column, double instead) {
      return column ? table.number(row, *column, 0.0, kThickest_per_m, problems).value_or(instead) : instead;
    };
    AirByOthers air;
    const double g = read(green, 0.0);
    air.per_m = {read(red, g), g, read(blue, g)};
    air.sigma_per_m = sigma ? glm::dvec3(read(sigma, 0.0)) : kUsualSigma * air.per_m;
    if (time) rows.emplace_back(*time, air);
  }
  if (!problems.empty()) return fail(problems.fault());
  std::vector<AirByOthers> airs;
  for (const auto& view : scene.views) {
    airs.push_back({{}, {}, "the table of the air has no line for that time"});
    if (!view.utc || rows.empty()) continue;
    const auto away = [&](const auto& row) { return std::chrono::abs(row.first - *view.utc); };
    const auto nearest = std::ranges::min_element(rows, {}, away);
    if (away(*nearest) <= kNear) airs.back() = nearest->second;
  }
  return airs;
}

}  // namespace kasumi
