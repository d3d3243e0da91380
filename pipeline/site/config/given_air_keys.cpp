#include "pipeline/site/config/given_air_keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kasumi {
namespace {

constexpr std::string_view kAuto = "auto";

std::optional<double> number_or_auto(const ConfigTable& table, std::string_view key, Range range) {
  if (!table.has(key) || table.if_text(key) == kAuto) return std::nullopt;
  const auto value = table.if_number(key);
  if (value && *value >= range.lowest && *value <= range.highest) return value;
  table.problem(key, fmt::format("a number from {:g} to {:g}, or \"{}\"", range.lowest, range.highest, kAuto));
  return std::nullopt;
}

std::optional<AerosolKind> kind_or_auto(const ConfigTable& table, std::string_view key) {
  const auto text = table.if_text(key);
  if (!table.has(key) || text == kAuto) return std::nullopt;
  if (text)
    if (const auto kind = aerosol_kind_named(*text)) return kind;
  std::vector<std::string_view> names;
  for (const AerosolKind kind : kAerosolKinds) names.push_back(name_of(kind));
  table.problem(key, fmt::format("one of \"{}\", or \"{}\"", fmt::join(names, "\", \""), kAuto));
  return std::nullopt;
}

}  // namespace

GivenAir read_given_air(const ConfigTable& site) {
  return {number_or_auto(site, "aod_550", {0.0, kHighestGivenAod}),
          number_or_auto(site, "angstrom_exponent", {kLowestGivenExponent, kHighestGivenExponent}),
          kind_or_auto(site, "aerosol")};
}

}  // namespace kasumi
