#include "pipeline/camera_drift/drift_reference.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/statistics.hpp"
#include "capture/utc_text.hpp"
#include "pipeline/files/photograph_file.hpp"
#include "pipeline/files/picture_sink.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::json;

constexpr int kReferenceFormat = 1;

std::filesystem::path with(const std::filesystem::path& stem, const char* ending) {
  auto path = stem;
  path += ending;
  return path;
}

Image<Rgb8> picture_of(const GreyPicture& grey) {
  Image<Rgb8> picture(grey.width(), grey.height());
  std::transform(grey.elements().begin(), grey.elements().end(), picture.elements().begin(),
                 [](std::uint8_t value) { return Rgb8(value); });
  return picture;
}

// Light as 8 bits with a square root: relative steps of 1 % in the bright half.
Image<Rgb8> picture_of(const DomeFrame& dome) {
  Image<Rgb8> picture(dome.width(), dome.height());
  std::transform(
      dome.elements().begin(), dome.elements().end(), picture.elements().begin(),
      [](const glm::vec3& light) { return Rgb8(glm::round(255.0f * glm::sqrt(glm::clamp(light, 0.0f, 1.0f)))); });
  return picture;
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

DomeFrame median_look(const std::vector<DomeFrame>& looks) {
  DomeFrame still(looks[0].width(), looks[0].height());
  std::vector<float> values(looks.size());
  for (std::size_t i = 0; i < still.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < looks.size(); ++k) values[k] = looks[k].elements()[i][c];
      still.elements()[i][c] = median_in_place(values);
    }
  return still;
}

ViewReference view_of(const std::vector<GreyPicture>& pictures, const Camera& camera,
                      const Image<std::uint8_t>& usable) {
  const auto still = median_of(pictures);
  return {shrunk(still, camera), find_edges(light_of(still, camera), usable)};
}

// A camera's saved reference; empty when it is missing or damaged.
std::optional<ViewReference> read_view(const Json& json, const char* name, const std::filesystem::path& file) {
  if (!json.contains(name)) return std::nullopt;
  auto edges = edges_of(json[name]);
  const auto photograph = read_photograph(file);
  if (!edges || !photograph) return std::nullopt;
  const auto rgb = to_rgb8(*photograph);
  ViewReference view{GreyPicture(rgb.width(), rgb.height()), std::move(*edges)};
  std::transform(rgb.elements().begin(), rgb.elements().end(), view.small.elements().begin(),
                 [](const Rgb8& c) { return c.g; });
  return view;
}

}  // namespace

Result<DriftReference> take_reference(const DriftFrames& frames, const Installation& installation, Utc now) {
  const auto enough = [](const auto& pictures) { return pictures.size() >= std::size_t{kFewestCheckFrames}; };
  if (!enough(frames.scene()) && !enough(frames.sky()))
    return fail(FaultKind::bad_input, "{} pictures of the scene, {} of the sky: expected at least {} of one of them",
                frames.scene().size(), frames.sky().size(), kFewestCheckFrames);
  DriftReference reference;
  reference.taken = now;
  reference.scene_calibrated = installation.scene.calibrated_utc;
  reference.sky_calibrated = installation.sky.calibrated_utc;
  if (enough(frames.scene())) reference.scene = view_of(frames.scene(), installation.scene, {});
  if (enough(frames.sky())) {
    reference.sky = view_of(frames.sky(), installation.sky, still_part_of_sky(installation.sky, 1));
    reference.dome = median_look(frames.dome());
    reference.suns = frames.sun_places();
  }
  reference.turbidity = median_if_enough(frames.turbidities());
  reference.level = median_if_enough(frames.levels());
  return reference;
}

bool belongs_to(const DriftReference& reference, const Installation& installation) {
  const auto fits = [](const std::optional<ViewReference>& view, const Camera& camera) {
    const int factor = shrink_factor(camera);
    return !view || (view->small.width() == camera.width / factor && view->small.height() == camera.height / factor);
  };
  return reference.scene_calibrated == installation.scene.calibrated_utc &&
         reference.sky_calibrated == installation.sky.calibrated_utc && fits(reference.scene, installation.scene) &&
         fits(reference.sky, installation.sky);
}

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
  // Pictures first, so that the JSON file never names missing ones.
  for (const auto& [view, name, ending] : {std::tuple{&reference.scene, "scene_edges", ".check-scene.png"},
                                           std::tuple{&reference.sky, "sky_edges", ".check-sky.png"}}) {
    if (!*view) continue;
    json[name] = json_of((*view)->edges);
    if (auto written = write_png(with(stem, ending), picture_of((*view)->small)); !written) return written;
  }
  if (reference.dome)
    if (auto written = write_png(with(stem, ".check-dome.png"), picture_of(*reference.dome)); !written) return written;
  return write_text_file(with(stem, ".check.json"), json.dump(1) + "\n");
}

Result<DriftReference> load_reference(const std::filesystem::path& stem) {
  const auto file = with(stem, ".check.json");
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return fail(FaultKind::io, "{}: there is no reference yet", file.string());
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  const auto json = Json::parse(*text, nullptr, false);
  const auto damaged = [&] {
    return fail(FaultKind::bad_input, "{}: expected a reference that kasumi calibrate check wrote; take a new one",
                file.string());
  };
  if (!json.is_object() || json.value("check_reference", Json()) != Json(kReferenceFormat)) return damaged();
  DriftReference reference;
  const auto taken = utc_of(json, "taken_utc");
  if (!taken) return damaged();
  reference.taken = *taken;
  reference.scene_calibrated = utc_of(json, "scene_calibrated_utc");
  reference.sky_calibrated = utc_of(json, "sky_calibrated_utc");
  reference.scene = read_view(json, "scene_edges", with(stem, ".check-scene.png"));
  reference.sky = read_view(json, "sky_edges", with(stem, ".check-sky.png"));
  if (json.contains("scene_edges") != reference.scene.has_value() ||
      json.contains("sky_edges") != reference.sky.has_value())
    return damaged();
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
  if (reference.sky)
    if (const auto photograph = read_photograph(with(stem, ".check-dome.png"))) {
      reference.dome = photograph->encoded;
      for (auto& value : reference.dome->elements()) value *= value;
    }
  return reference;
}

std::filesystem::path reference_stem(const Installation& installation, const std::filesystem::path& root_file) {
  auto stem = installation.calibration ? installation.calibration->file : root_file;
  return stem.replace_extension();
}

}  // namespace kasumi
