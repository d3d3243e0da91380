#include "pipeline/lab/photographs/haze_answer.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::ordered_json;

// Dividing gives the double that prints with those digits.
double rounded_to(double value, int digits) {
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}
Json channels(const glm::dvec3& values) {
  Json list = Json::array();
  for (int c = 0; c < 3; ++c) list.push_back(rounded_to(values[c], 4));
  return list;
}

// Pictures of one size, and their named part.
struct AnswerGroup {
  Camera camera;
  std::vector<std::size_t> answers;
  std::vector<std::optional<PartContrast>> parts;
};

// The part of all pictures as one landmark. Without a distance each by itself: nothing is known of how clear hours look.
void add_depths(const HazeQuestion& question, const AnswerGroup& same, std::vector<Result<HazeAnswer>>& answers) {
  constexpr double kAnyDistance_m = 1000.0;
  ContrastLandmark landmark;
  landmark.distance_m = question.distance_m.value_or(kAnyDistance_m);
  landmark.infinity_sigma = 0.0;
  double spread = 0.0;
  std::vector<std::vector<ContrastReading>> readings;
  for (const auto& part : same.parts) {
    readings.push_back({{part.has_value(), part ? "" : "the part is outside of the picture", {}, {}}});
    if (!part) continue;
    readings.back()[0].contrast = part->contrast;
    readings.back()[0].sigma = part->sigma;
    landmark.infinity_sigma = std::max(landmark.infinity_sigma, part->infinity_sigma);
    spread = std::max(spread, part->spread);
  }
  landmark.contrast_sigma = std::hypot(landmark.contrast_sigma, 0.5 * spread);
  ContrastSpread spreads;
  spreads.fog_patchy = 0.0;  // the path that is asked for is the one that is seen
  const LandmarkWatch watch(same.camera, question.altitude_m, {landmark}, spreads, ScatteringModel::aerosol);
  std::vector<ChannelExtinctions> airs;
  if (question.distance_m && readings.size() > 1)
    airs = watch.estimate_all(readings);
  else
    for (const auto& one : readings) airs.push_back(watch.estimate(one));
  for (std::size_t i = 0; i < airs.size(); ++i) {
    auto& answer = answers[same.answers[i]].value();
    const auto& green = airs[i].extinction();
    if (green.kind == ExtinctionKind::nothing || green.kind == ExtinctionKind::at_least) {
      answer.doubt = green.reason;
      continue;
    }
    const double sigma_per_m =
        green.kind == ExtinctionKind::value ? green.sigma_per_m : 0.5 * (green.highest_per_m - green.per_m);
    glm::dvec3 per_m;
    for (int c = 0; c < 3; ++c) per_m[c] = airs[i].channels[static_cast<std::size_t>(c)].per_m;
    answer.depth = HazeDepth{per_m * landmark.distance_m, sigma_per_m * landmark.distance_m};
    if (!question.distance_m) continue;
    const double aerosol =
        std::max(0.0, per_m.g - rayleigh_per_m(ScatteringModel::aerosol, 550.0, question.altitude_m));
    answer.extinction_per_m = per_m.g;
    answer.sigma_per_m = sigma_per_m;
    answer.aod_550 = aerosol * kAerosolHeight_m * std::exp(question.altitude_m / kAerosolHeight_m);
    if (answer.colour.told) answer.exponent = aerosol_exponent(answer.colour, Aerosol{*answer.aod_550});
  }
}

// The value, or the bound by two sigma.
double visibility_m(const HazeAnswer& answer) {
  return kMeteorologicalRange / (*answer.extinction_per_m + (answer.clear() ? 2.0 * *answer.sigma_per_m : 0.0));
}

}  // namespace

std::vector<Result<HazeAnswer>> hazes_of(const std::vector<std::filesystem::path>& pictures,
                                         const HazeQuestion& question) {
  std::vector<Result<HazeAnswer>> answers;
  std::map<std::pair<int, int>, AnswerGroup> cameras;
  for (const auto& picture : pictures) {
    const auto photograph = read_photograph(picture);
    if (!photograph) {
      answers.push_back(fail(photograph.error()));
      continue;
    }
    const int width = photograph->encoded.width(), height = photograph->encoded.height();
    const auto camera = plain_camera(width, height, from_degrees(50.0), Radians{0.0});
    const auto hazy = hazy_picture(camera, *photograph);
    HazeAnswer answer;
    answer.picture = picture;
    answer.colour = haze_colour_of(camera, hazy);
    answer.from_infinity = hazy.from_infinity;
    answer.from_sky = hazy.from_sky;
    answer.exponent = answer.colour.told ? answer.colour.exponent : Aerosol{}.angstrom_exponent;
    if (question.part) {
      auto& same = cameras.try_emplace({width, height}, AnswerGroup{camera, {}, {}}).first->second;
      same.answers.push_back(answers.size());
      same.parts.push_back(part_contrast(hazy, *question.part));
    }
    answers.push_back(std::move(answer));
  }
  for (const auto& [size, same] : cameras) add_depths(question, same, answers);
  return answers;
}

std::string haze_json(const HazeAnswer& answer) {
  const auto& colour = answer.colour;
  const bool tried = colour.sigma > 0.0;
  Json json;
  json["haze"] = answer.picture.string();
  json["told"] = colour.told;
  json["reason"] = colour.reason;
  json["exponent"] = tried ? Json(rounded_to(colour.exponent, 3)) : Json(nullptr);
  json["sigma_exponent"] = tried ? Json(rounded_to(colour.sigma, 3)) : Json(nullptr);
  json["depth_range"] = tried ? Json(rounded_to(colour.depth_range, 3)) : Json(nullptr);
  json["places"] = colour.places;
  json["from_infinity"] = channels(answer.from_infinity);
  json["infinity_from"] = answer.from_sky ? "low sky" : "thickest haze";
  json["optical_depth"] = answer.depth ? channels(answer.depth->depth) : Json(nullptr);
  json["sigma_optical_depth"] = answer.depth ? Json(rounded_to(answer.depth->sigma, 3)) : Json(nullptr);
  json["extinction_per_m"] = answer.extinction_per_m ? Json(rounded_to(*answer.extinction_per_m, 7)) : Json(nullptr);
  json["sigma_per_m"] = answer.sigma_per_m ? Json(rounded_to(*answer.sigma_per_m, 7)) : Json(nullptr);
  json["visibility"] = answer.extinction_per_m ? Json(answer.clear() ? "at least" : "value") : Json(nullptr);
  json["visibility_m"] = answer.extinction_per_m ? Json(std::round(visibility_m(answer))) : Json(nullptr);
  json["aod_550"] = answer.aod_550 ? Json(rounded_to(*answer.aod_550, 4)) : Json(nullptr);
  json["angstrom_exponent"] = rounded_to(answer.exponent, 3);
  return text_of_json(json) + "\n";
}

std::string haze_text(const HazeAnswer& answer) {
  const auto& colour = answer.colour;
  auto text = fmt::format("{}\n  light from infinity  R {:.3f}, G {:.3f}, B {:.3f} of full scale, by {}\n",
                          answer.picture.string(), answer.from_infinity.r, answer.from_infinity.g,
                          answer.from_infinity.b, answer.from_sky ? "the low sky" : "the thickest haze");
  if (colour.told)
    text +=
        fmt::format("  colour of the haze   exponent {:.2f} +- {:.2f}, by {} places over an optical depth of {:.2f}\n",
                    colour.exponent, colour.sigma, colour.places, colour.depth_range);
  else
    text += fmt::format("  colour of the haze   not determined by the picture: {}\n", colour.reason);
  if (answer.depth)
    text += fmt::format("  optical depth        R {:.2f}, G {:.2f}, B {:.2f} +- {:.2f}\n", answer.depth->depth.r,
                        answer.depth->depth.g, answer.depth->depth.b, answer.depth->sigma);
  if (!answer.depth && !answer.doubt.empty()) text += fmt::format("  optical depth        {}\n", answer.doubt);
  if (answer.extinction_per_m)
    text += fmt::format(
        "  extinction           {:.3f} +- {:.3f} per km: visibility {}{:.2f} km\n"
        "  aerosol              optical depth {:.2f} of the column, exponent {:.2f}{}\n",
        1e3 * *answer.extinction_per_m, 1e3 * *answer.sigma_per_m, answer.clear() ? "at least " : "",
        1e-3 * visibility_m(answer), *answer.aod_550, answer.exponent, colour.told ? "" : " (supposed)");
  return text;
}

}  // namespace kasumi
