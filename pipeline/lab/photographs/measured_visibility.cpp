#include "pipeline/lab/photographs/measured_visibility.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "base/files.hpp"
#include "base/finite_number.hpp"
#include "base/statistics.hpp"
#include "base/table/config_table.hpp"

namespace kasumi {
namespace {

std::string range_text(double metres) {
  return metres < 1000.0 ? fmt::format("{:.0f} m", metres) : fmt::format("{:.2f} km", 1e-3 * metres);
}

}  // namespace

Result<MeasuredVisibilities> read_measured_visibilities(const std::filesystem::path& file) {
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  std::istringstream lines(*text);
  std::string line;
  std::getline(lines, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (line != "name,visibility_m")
    return fail(FaultKind::bad_input, "{}: expected name,visibility_m in its first line", file.string());
  MeasuredVisibilities found;
  Problems problems;
  for (int number = 2; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const auto comma = line.find(',');
    const std::string value = comma == std::string::npos ? std::string() : line.substr(comma + 1);
    const auto metres = finite_number(value);
    if (!metres || *metres <= 0.0)
      problems.add("{}: line {}: expected a picture's name, a comma and more than 0 metres", file.string(), number);
    else
      found[line.substr(0, comma)] = *metres;
  }
  if (!problems.empty()) return fail(problems.fault());
  return found;
}

VisibilityCheck check_visibility(const ChannelExtinctions& air, double measured_m) {
  const auto& green = air.extinction();
  VisibilityCheck check;
  check.kind = green.kind;
  check.measured_m = measured_m;
  if (green.kind == ExtinctionKind::nothing) return check;
  check.ours_m = air.optical_range_m();
  check.factor = check.ours_m / measured_m;
  const double measured_per_m = kMeteorologicalOpticalRange / measured_m;
  if (green.kind == ExtinctionKind::value) {
    check.sigmas = (green.per_m - measured_per_m) / green.sigma_per_m;
    check.holds = std::abs(check.sigmas) <= 2.0;
  } else {
    check.holds = green.kind == ExtinctionKind::at_most ? measured_m >= check.ours_m : measured_m <= check.ours_m;
  }
  return check;
}

std::string check_text(const VisibilityCheck& check) {
  const auto measured = range_text(check.measured_m);
  switch (check.kind) {
    case ExtinctionKind::nothing: return fmt::format("  measured         {}; ours is not known\n", measured);
    case ExtinctionKind::value:
      return fmt::format(
          "  measured         {} (optical range); ours {} is {:.2f} times that, its extinction {:+.1f} sigma off\n",
          measured, range_text(check.ours_m), check.factor, check.sigmas);
    default:
      return fmt::format("  measured         {} (optical range); our bound of {} {}\n", measured,
                         range_text(check.ours_m), check.holds ? "holds" : "does not hold");
  }
}

std::string checks_text(const std::vector<VisibilityCheck>& checks) {
  std::vector<double> factors;
  int sure = 0, bounds = 0, kept = 0;
  for (const auto& check : checks) {
    if (check.kind == ExtinctionKind::nothing) continue;
    if (check.kind == ExtinctionKind::value) {
      factors.push_back(std::exp(std::abs(std::log(check.factor))));
      sure += check.holds ? 1 : 0;
    } else {
      ++bounds;
      kept += check.holds ? 1 : 0;
    }
  }
  auto text = fmt::format("measured beside {} pictures: {} of them give a value", checks.size(), factors.size());
  if (!factors.empty())
    text += fmt::format(", off by a factor of {:.2f} in the median and {:.2f} at most, {} within 2 sigma",
                        median(factors), *std::ranges::max_element(factors), sure);
  return text + fmt::format("; {} give a bound, of which {} hold\n", bounds, kept);
}

}  // namespace kasumi
