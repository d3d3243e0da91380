#include "pipeline/lab/photographs/estimate_csv.hpp"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "base/utc_text.hpp"

namespace kasumi {
namespace {

struct CsvColumn {
  const char* name;
  const char* pointer;  // into the answer
};
constexpr std::array kColumns{CsvColumn{"image", "/image"},
                              CsvColumn{"utc", "/utc"},
                              CsvColumn{"usable", "/usable"},
                              CsvColumn{"turbidity", "/turbidity"},
                              CsvColumn{"sigma", "/sigma"},
                              CsvColumn{"aod_550", "/aod_550"},
                              CsvColumn{"sigma_aod_550", "/sigma_aod_550"},
                              CsvColumn{"angstrom_exponent", "/angstrom_exponent"},
                              CsvColumn{"visibility_m", "/visibility_m"},
                              CsvColumn{"sky", "/sky"},
                              CsvColumn{"cloud_fraction", "/cloud_fraction"},
                              CsvColumn{"sigma_cloud_fraction", "/sigma_cloud_fraction"},
                              CsvColumn{"sun_zenith_deg", "/sun_zenith_deg"},
                              CsvColumn{"sun_azimuth_deg", "/sun_azimuth_deg"},
                              CsvColumn{"sun_sigma_deg", "/sun_sigma_deg"},
                              CsvColumn{"circle_x", "/circle/0"},
                              CsvColumn{"circle_y", "/circle/1"},
                              CsvColumn{"circle_r", "/circle/2"},
                              CsvColumn{"reason", "/reason"}};

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
  return quoted(value.is_string() ? value.get<std::string>() : value.dump());
}

std::string line_of(nlohmann::json answer, const std::optional<Utc>& utc) {
  if (utc) answer["utc"] = utc_text(*utc);
  std::string line;
  for (const auto& column : kColumns) line += (&column == kColumns.data() ? "" : ",") + cell_of(answer, column.pointer);
  return line + "\n";
}

}  // namespace

std::string estimate_csv_header() {
  std::string line;
  for (const auto& column : kColumns) line += std::string(line.empty() ? "" : ",") + column.name;
  return line + "\n";
}

std::string estimate_csv_line(std::string_view answer, const std::optional<Utc>& utc) {
  return line_of(nlohmann::json::parse(answer), utc);
}

std::string estimate_csv_line(const std::string& image, const std::optional<Utc>& utc, const std::string& reason) {
  auto on_one_line = reason;
  std::ranges::replace(on_one_line, '\n', ' ');
  return line_of({{"image", image}, {"usable", false}, {"reason", on_one_line}}, utc);
}

}  // namespace kasumi
