#include "pipeline/lab/archive/estimate_csv.hpp"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

constexpr std::array kColumns{CsvColumn{"image", "/image", "TEXT"},
                              CsvColumn{"utc", "/utc", "TEXT"},
                              CsvColumn{"usable", "/usable", "INTEGER"},
                              CsvColumn{"turbidity", "/turbidity", "REAL"},
                              CsvColumn{"sigma", "/sigma", "REAL"},
                              CsvColumn{"aod_550", "/aod_550", "REAL"},
                              CsvColumn{"sigma_aod_550", "/sigma_aod_550", "REAL"},
                              CsvColumn{"angstrom_exponent", "/angstrom_exponent", "REAL"},
                              CsvColumn{"visibility_m", "/visibility_m", "REAL"},
                              CsvColumn{"sky", "/sky", "TEXT"},
                              CsvColumn{"cloud_fraction", "/cloud_fraction", "REAL"},
                              CsvColumn{"sigma_cloud_fraction", "/sigma_cloud_fraction", "REAL"},
                              CsvColumn{"sun_zenith_deg", "/sun_zenith_deg", "REAL"},
                              CsvColumn{"sun_azimuth_deg", "/sun_azimuth_deg", "REAL"},
                              CsvColumn{"sun_sigma_deg", "/sun_sigma_deg", "REAL"},
                              CsvColumn{"circle_x", "/circle/0", "REAL"},
                              CsvColumn{"circle_y", "/circle/1", "REAL"},
                              CsvColumn{"circle_r", "/circle/2", "REAL"},
                              CsvColumn{"reason", "/reason", "TEXT"}};

// RFC 4180.
std::string quoted(std::string text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  for (auto at = text.find('"'); at != std::string::npos; at = text.find('"', at + 2)) text.insert(at, 1, '"');
  return '"' + text + '"';
}

std::string cell_of(const nlohmann::json& answer, const char* pointer) {
  const nlohmann::json::json_pointer place(pointer);
  if (!answer.contains(place) || answer[place].is_null()) return {};
  const auto& value = answer[place];
  return quoted(value.is_string() ? value.get<std::string>() : text_of_json(value));
}

std::string line_of(nlohmann::json answer, const std::optional<Utc>& utc) {
  if (utc) answer["utc"] = utc_text(*utc);
  return csv_line_of_record(answer);
}

}  // namespace

std::span<const CsvColumn> estimate_columns() {
  return kColumns;
}

std::string csv_line_of_record(const nlohmann::json& record) {
  std::string line;
  for (const auto& column : kColumns) line += (&column == kColumns.data() ? "" : ",") + cell_of(record, column.pointer);
  return line + "\n";
}

std::string estimate_csv_header() {
  std::string line;
  for (const auto& column : kColumns) line += std::string(line.empty() ? "" : ",") + column.name;
  return line + "\n";
}

std::string estimate_csv_line(std::string_view answer, const std::optional<Utc>& utc) {
  return line_of(parse_json(answer), utc);
}

std::string estimate_csv_line(const std::string& image, const std::optional<Utc>& utc, const std::string& reason) {
  auto on_one_line = reason;
  std::ranges::replace(on_one_line, '\n', ' ');
  return line_of({{"image", image}, {"usable", false}, {"reason", on_one_line}}, utc);
}

}  // namespace kasumi
