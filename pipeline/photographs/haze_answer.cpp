#include "pipeline/photographs/haze_answer.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "estimator/landmarks/landmark_air.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/files/photograph_file.hpp"

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

// The value, or the bound by two sigma.
double visibility_m(const HazeAnswer& answer) {
  return kMeteorologicalRange / (*answer.extinction_per_m + (answer.clear() ? 2.0 * *answer.sigma_per_m : 0.0));
}

}  // namespace

Result<HazeAnswer> haze_of(const std::filesystem::path& picture, const HazeQuestion& question) {
  const auto photograph = read_photograph(picture);
  if (!photograph) return fail(photograph.error());
  const auto camera =
      plain_camera(photograph->encoded.width(), photograph->encoded.height(), from_degrees(50.0), Radians{0.0});
  const auto hazy = hazy_picture(camera, *photograph);
  HazeAnswer answer;
  answer.picture = picture;
  answer.colour = haze_colour_of(camera, hazy);
  answer.from_infinity = hazy.from_infinity;
  answer.from_sky = hazy.from_sky;
  answer.exponent = answer.colour.told ? answer.colour.exponent : Aerosol{}.angstrom_exponent;
  if (question.part) answer.depth = haze_depth_of(hazy, *question.part);
  if (answer.depth && question.distance_m) {
    const double per_m = answer.depth->depth.g / *question.distance_m;
    const double aerosol = std::max(0.0, per_m - rayleigh_per_m(ScatteringModel::aerosol, 550.0, question.altitude_m));
    answer.extinction_per_m = per_m;
    answer.sigma_per_m = answer.depth->sigma / *question.distance_m;
    answer.aod_550 = aerosol * kAerosolHeight_m * std::exp(question.altitude_m / kAerosolHeight_m);
    if (answer.colour.told) answer.exponent = aerosol_exponent(answer.colour, Aerosol{*answer.aod_550});
  }
  return answer;
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
  return json.dump() + "\n";
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
    text += fmt::format("  colour of the haze   the picture does not tell: {}\n", colour.reason);
  if (answer.depth)
    text += fmt::format("  optical depth        R {:.2f}, G {:.2f}, B {:.2f} +- {:.2f}\n", answer.depth->depth.r,
                        answer.depth->depth.g, answer.depth->depth.b, answer.depth->sigma);
  if (answer.extinction_per_m)
    text += fmt::format(
        "  extinction           {:.3f} +- {:.3f} per km: visibility {}{:.2f} km\n"
        "  aerosol              optical depth {:.2f} of the column, exponent {:.2f}{}\n",
        1e3 * *answer.extinction_per_m, 1e3 * *answer.sigma_per_m, answer.clear() ? "at least " : "",
        1e-3 * visibility_m(answer), *answer.aod_550, answer.exponent, colour.told ? "" : " (supposed)");
  return text;
}

}  // namespace kasumi
