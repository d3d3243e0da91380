#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "calib/colour/spectral_sensitivity.hpp"

namespace kasumi {
namespace {

constexpr const char* kChannelNames[] = {"red", "green", "blue"};

struct Row {
  double nm;
  glm::dvec3 value;
};

std::string trimmed(std::string_view text) {
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return std::string(text);
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::optional<double> number_in(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// 0, 1, 2 for "R", "red_qe", "Green", "b", ...
std::optional<int> channel_of(const std::string& name) {
  const auto word = lower_case(name);
  for (int c = 0; c < 3; ++c)
    if (word == std::string(1, kChannelNames[c][0]) || word.starts_with(kChannelNames[c])) return c;
  return std::nullopt;
}

std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, separator);) cells.push_back(trimmed(cell));
  return cells;
}

// One column for the wavelength (the first) and one for each channel, as the header names them.
std::vector<Row> read_csv(const std::string& text, Problems& problems) {
  std::istringstream file(text);
  std::vector<Row> rows;
  std::array<std::size_t, 3> columns{};  // 0 until the header was read: column 0 is the wavelength
  char separator = ',';
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (trimmed(line).empty() || line[0] == '#') continue;
    if (columns[0] == 0) {
      for (const char candidate : {';', '\t'})
        if (line.find(candidate) != std::string::npos) separator = candidate;
      const auto names = cells_of(line, separator);
      for (std::size_t i = 1; i < names.size(); ++i)
        if (const auto c = channel_of(names[i]); c && columns[*c] == 0) columns[*c] = i;
      for (int c = 0; c < 3; ++c)
        if (columns[c] == 0)
          problems.add("line {}: the header has no column for {}: expected wavelength, red, green, blue", number,
                       kChannelNames[c]);
      if (!problems.empty()) return {};
      continue;
    }
    const auto cells = cells_of(line, separator);
    const auto cell = [&](std::size_t i) { return i < cells.size() ? cells[i] : std::string(); };
    Row row{};
    const auto nm = number_in(cell(0));
    if (!nm) problems.add("line {}: wavelength \"{}\": expected a number in nm", number, cell(0));
    row.nm = nm.value_or(0.0);
    bool whole = nm.has_value();
    for (int c = 0; c < 3; ++c) {
      const auto value = number_in(cell(columns[c]));
      if (!value) problems.add("line {}: {} \"{}\": expected a number", number, kChannelNames[c], cell(columns[c]));
      row.value[c] = value.value_or(0.0);
      whole = whole && value.has_value();
    }
    if (whole) rows.push_back(row);
  }
  if (columns[0] == 0) problems.add("no header line: expected wavelength, red, green, blue");
  return rows;
}

// spectral_data.index.main names the channels, spectral_data.data.main has their values by wavelength.
std::vector<Row> read_rawtoaces(const std::string& text, Problems& problems) {
  const auto json = parse_json(text);
  if (json.is_discarded()) {
    problems.add("not valid JSON");
    return {};
  }
  const auto at = [&](const char* path) {
    const nlohmann::json::json_pointer pointer(path);
    return json.contains(pointer) ? json.at(pointer) : nlohmann::json();
  };
  const auto index = at("/spectral_data/index/main");
  const auto data = at("/spectral_data/data/main");

  std::array<std::optional<std::size_t>, 3> places;
  for (std::size_t i = 0; index.is_array() && i < index.size(); ++i)
    if (index[i].is_string())
      if (const auto c = channel_of(index[i].get<std::string>()); c && !places[*c]) places[*c] = i;
  if (!places[0] || !places[1] || !places[2])
    problems.add("spectral_data.index.main: expected the names \"R\", \"G\" and \"B\"");
  if (!data.is_object() || data.empty())
    problems.add("spectral_data.data.main: expected wavelengths in nm with one value per channel");
  if (!problems.empty()) return {};

  std::vector<Row> rows;
  for (const auto& [key, values] : data.items()) {
    const auto nm = number_in(key);
    if (!nm) {
      problems.add("spectral_data.data.main: \"{}\": expected a wavelength in nm", key);
      continue;
    }
    const bool whole = values.is_array() && values.size() == index.size() &&
                       std::all_of(values.begin(), values.end(), [](const auto& value) { return value.is_number(); });
    if (!whole) {
      problems.add("spectral_data.data.main.{}: expected {} numbers", key, index.size());
      continue;
    }
    Row row{*nm, {}};
    for (int c = 0; c < 3; ++c) row.value[c] = values[*places[c]].get<double>();
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.nm < b.nm; });
  return rows;
}

void check(const std::vector<Row>& rows, Problems& problems) {
  if (rows.size() < 3) {
    problems.add("{} wavelengths: expected at least 3", rows.size());
    return;
  }
  glm::dvec3 largest{0.0};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!(rows[i].nm >= 200.0 && rows[i].nm <= 2500.0))
      problems.add("wavelength {}: expected a number from 200 to 2500, in nm", rows[i].nm);
    if (i > 0 && !(rows[i].nm > rows[i - 1].nm))
      problems.add("wavelength {} after {}: expected increasing wavelengths", rows[i].nm, rows[i - 1].nm);
    for (int c = 0; c < 3; ++c)
      if (!std::isfinite(rows[i].value[c]) || rows[i].value[c] < 0.0)
        problems.add("{} at {} nm is {}: expected a number >= 0", kChannelNames[c], rows[i].nm, rows[i].value[c]);
    largest = glm::max(largest, rows[i].value);
  }
  for (int c = 0; c < 3; ++c)
    if (!(largest[c] > 0.0)) problems.add("{} is zero at every wavelength", kChannelNames[c]);
}

glm::dvec3 between_rows(const std::vector<Row>& rows, double nm) {
  auto above =
      std::lower_bound(rows.begin() + 1, rows.end() - 1, nm, [](const Row& row, double x) { return row.nm < x; });
  const auto& high = *above;
  const auto& low = *(above - 1);
  return glm::mix(low.value, high.value, (nm - low.nm) / (high.nm - low.nm));
}

// Evenly spaced at the finest step of the rows, but no finer than 1 nm; the largest value becomes 1.
SpectralSensitivity resampled(const std::vector<Row>& rows, std::string name) {
  double finest = rows[1].nm - rows[0].nm;
  for (std::size_t i = 2; i < rows.size(); ++i) finest = std::min(finest, rows[i].nm - rows[i - 1].nm);
  const double span = rows.back().nm - rows.front().nm;
  const auto steps = std::max(1.0, std::round(span / std::max(finest, 1.0)));

  SpectralSensitivity sensitivity{std::move(name), rows.front().nm, span / steps, {}};
  double largest = 0.0;
  for (double i = 0.0; i <= steps; i += 1.0) {
    const auto value = between_rows(rows, rows.front().nm + i * sensitivity.step_nm);
    largest = std::max({largest, value.r, value.g, value.b});
    sensitivity.samples.push_back(value);
  }
  for (auto& sample : sensitivity.samples) sample /= largest;
  return sensitivity;
}

}  // namespace

Result<SpectralSensitivity> read_spectral_sensitivity(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());

  Problems problems;
  std::vector<Row> rows;
  const auto extension = lower_case(path.extension().string());
  if (extension == ".json")
    rows = read_rawtoaces(*text, problems);
  else if (extension == ".csv")
    rows = read_csv(*text, problems);
  else
    problems.add("expected a rawtoaces .json or a .csv of wavelength, red, green, blue");
  if (problems.empty()) check(rows, problems);
  if (problems.empty()) return resampled(rows, path.stem().string());

  Problems named;
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < std::min(kShown, problems.lines().size()); ++i)
    named.add("{}: {}", path.string(), problems.lines()[i]);
  if (problems.lines().size() > kShown)
    named.add("{}: and {} more problems", path.string(), problems.lines().size() - kShown);
  return fail(named.fault());
}

}  // namespace kasumi
