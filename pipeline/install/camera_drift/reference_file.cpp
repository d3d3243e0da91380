// STEM.check.json: numbers, and grids of digits.
#include <tuple>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/install/camera_drift/drift_reference.hpp"
#include "pipeline/install/camera_drift/reference_pictures.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::json;

// Raised when the file's meaning changes; format 1 kept pictures.
constexpr int kReferenceFormat = 2;
constexpr int kFormatWithPictures = 1;
// Of values in rows of text, one character each.
constexpr std::string_view kDigits = "0123456789abcdefghijklmnopqrstuvwxyz";
static_assert(ViewLines::kStrongest < int{kDigits.size()} && DomeShade::kSteepest < int{kDigits.size()});

std::filesystem::path reference_file(const std::filesystem::path& stem) {
  return stem.string() + ".check.json";
}

Json json_of(const std::vector<ViewEdge>& edges) {
  Json json = Json::array();
  for (const auto& edge : edges)
    json.push_back(
        {edge.pixel.x, edge.pixel.y, edge.normal.x, edge.normal.y, edge.spread_px, edge.contrast, edge.step});
  return json;
}

std::optional<std::vector<ViewEdge>> edges_of(const Json& json) {
  std::vector<ViewEdge> edges;
  if (!json.is_array()) return std::nullopt;
  for (const auto& row : json) {
    if (!row.is_array() || row.size() != 7) return std::nullopt;
    for (const auto& value : row)
      if (!value.is_number()) return std::nullopt;
    edges.push_back({{row[0], row[1]}, {row[2], row[3]}, row[4], row[5], row[6]});
    if (!(edges.back().spread_px > 0.0) || !(edges.back().contrast > 0.0) || !(edges.back().step > 0.0))
      return std::nullopt;
  }
  return edges;
}

Json or_null(const std::optional<Utc>& utc) {
  return utc ? Json(utc_text(*utc)) : Json(nullptr);
}
std::optional<Utc> utc_of(const Json& json, const char* key) {
  if (!json.contains(key) || !json[key].is_string()) return std::nullopt;
  return parse_utc(json[key].get<std::string>());
}

// A row of digits for each row.
Json json_of(const Image<std::uint8_t>& grid) {
  Json rows = Json::array();
  for (int y = 0; y < grid.height(); ++y) {
    std::string row;
    for (int x = 0; x < grid.width(); ++x) row += kDigits[grid.at(x, y)];
    rows.push_back(std::move(row));
  }
  return rows;
}

std::optional<Image<std::uint8_t>> grid_of(const Json& rows) {
  if (!rows.is_array() || rows.empty() || !rows[0].is_string()) return std::nullopt;
  const auto width = rows[0].get_ref<const std::string&>().size();
  if (width == 0 || width > std::size_t{kCheckSide_px} || rows.size() > std::size_t{kCheckSide_px}) return std::nullopt;
  Image<std::uint8_t> grid(static_cast<int>(width), static_cast<int>(rows.size()));
  for (std::size_t y = 0; y < rows.size(); ++y) {
    if (!rows[y].is_string()) return std::nullopt;
    const auto& row = rows[y].get_ref<const std::string&>();
    if (row.size() != width) return std::nullopt;
    for (std::size_t x = 0; x < width; ++x) {
      const auto digit = kDigits.find(row[x]);
      if (digit == std::string_view::npos) return std::nullopt;
      grid.at(static_cast<int>(x), static_cast<int>(y)) = static_cast<std::uint8_t>(digit);
    }
  }
  return grid;
}

Json json_of(const DarkPlaces& dark) {
  Json places = Json::array();
  for (const auto& place : dark.places) places.push_back({place.x, place.y});
  return {{"light", dark.light}, {"places", std::move(places)}};
}

std::optional<DarkPlaces> darkest_of(const Json& json, const Image<std::uint8_t>& lines) {
  if (!json.is_object() || !json.contains("light") || !json["light"].is_number() || !json.contains("places") ||
      !json["places"].is_array())
    return std::nullopt;
  DarkPlaces dark;
  dark.light = json["light"];
  for (const auto& place : json["places"]) {
    if (!place.is_array() || place.size() != 2 || !place[0].is_number_integer() || !place[1].is_number_integer())
      return std::nullopt;
    dark.places.push_back({place[0], place[1]});
    if (!lines.contains(dark.places.back().x, dark.places.back().y)) return std::nullopt;
  }
  return dark;
}

struct ReferenceKeys {
  const char *edges, *lines, *darkest;
};
// The file's names for each camera's rows.
constexpr ReferenceKeys kSceneKeys{"scene_edges", "scene_lines", "scene_darkest"};
constexpr ReferenceKeys kSkyKeys{"sky_edges", "sky_lines", "sky_darkest"};

std::optional<ViewReference> view_from(const Json& json, const ReferenceKeys& keys, const Camera& camera) {
  for (const auto* key : {keys.edges, keys.lines, keys.darkest})
    if (!json.contains(key)) return std::nullopt;
  auto edges = edges_of(json[keys.edges]);
  auto lines = grid_of(json[keys.lines]);
  if (!edges || !lines) return std::nullopt;
  auto darkest = darkest_of(json[keys.darkest], *lines);
  if (!darkest) return std::nullopt;
  return ViewReference{{std::move(*lines), shrink_factor(camera), {}}, std::move(*darkest), std::move(*edges)};
}

}  // namespace

Result<> save_reference(const DriftReference& reference, const std::filesystem::path& stem) {
  Json json;
  json["check_reference"] = kReferenceFormat;
  json["taken_utc"] = utc_text(reference.taken);
  json["scene_calibrated_utc"] = or_null(reference.scene_calibrated);
  json["sky_calibrated_utc"] = or_null(reference.sky_calibrated);
  json["suns"] = Json::array();
  for (const auto& sun : reference.suns) json["suns"].push_back({sun.x, sun.y, sun.z});
  if (reference.level) json["log_level"] = *reference.level;
  if (reference.turbidity) json["turbidity"] = *reference.turbidity;
  for (const auto& [view, keys] : {std::pair{&reference.scene, &kSceneKeys}, std::pair{&reference.sky, &kSkyKeys}}) {
    if (!*view) continue;
    json[keys->edges] = json_of((*view)->edges);
    json[keys->lines] = json_of((*view)->lines.strength);
    json[keys->darkest] = json_of((*view)->darkest);
  }
  if (reference.dome) json["dome_shade"] = json_of(reference.dome->steps);
  if (auto written = write_text_file(reference_file(stem), text_of_json(json, 1) + "\n"); !written) return written;
  return remove_kept_pictures(stem);
}

Result<DriftReference> load_reference(const std::filesystem::path& stem, const Installation& installation) {
  const auto file = reference_file(stem);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return fail(FaultKind::io, "{}: there is no reference yet", file.string());
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  const auto json = parse_json(modest_json(*text, 64 << 20));
  const auto damaged = [&] {
    return fail(FaultKind::bad_input, "{}: expected a reference that kasumi calibrate check wrote; take a new one",
                file.string());
  };
  if (!json.is_object()) return damaged();
  const auto format = json.value("check_reference", Json());
  if (format != Json(kReferenceFormat) && format != Json(kFormatWithPictures)) return damaged();
  DriftReference reference;
  const auto taken = utc_of(json, "taken_utc");
  if (!taken) return damaged();
  reference.taken = *taken;
  reference.scene_calibrated = utc_of(json, "scene_calibrated_utc");
  reference.sky_calibrated = utc_of(json, "sky_calibrated_utc");
  const auto number = [&](const char* key) {
    return json.contains(key) && json[key].is_number() ? std::optional(json[key].get<double>()) : std::nullopt;
  };
  reference.level = number("log_level");
  reference.turbidity = number("turbidity");
  for (const auto& sun : json.value("suns", Json::array())) {
    if (!sun.is_array() || sun.size() != 3 || !sun[0].is_number() || !sun[1].is_number() || !sun[2].is_number())
      return damaged();
    reference.suns.push_back({sun[0], sun[1], sun[2]});
  }
  if (format == Json(kFormatWithPictures)) {
    reference.scene = scene_of_kept_picture(stem, installation.scene);
    reference.sky = sky_of_kept_picture(stem, installation.sky);
    for (auto& [view, keys] : {std::pair{&reference.scene, &kSceneKeys}, std::pair{&reference.sky, &kSkyKeys}}) {
      if (!*view) continue;
      auto edges = json.contains(keys->edges) ? edges_of(json[keys->edges]) : std::nullopt;
      if (!edges) return damaged();
      (*view)->edges = std::move(*edges);
    }
    if (reference.sky) reference.dome = dome_of_kept_picture(stem, installation.sky, reference.suns);
  } else {
    reference.scene = view_from(json, kSceneKeys, installation.scene);
    reference.sky = view_from(json, kSkyKeys, installation.sky);
    if (json.contains("dome_shade")) {
      auto steps = grid_of(json["dome_shade"]);
      if (!steps) return damaged();
      reference.dome = DomeShade{std::move(*steps)};
    }
  }
  if (json.contains(kSceneKeys.edges) != reference.scene.has_value() ||
      json.contains(kSkyKeys.edges) != reference.sky.has_value())
    return damaged();
  return reference;
}

}  // namespace kasumi
