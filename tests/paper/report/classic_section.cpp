#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "estimator/horizon/horizon.hpp"
#include "estimator/photograph/depth_from_haze.hpp"
#include "estimator/photograph/picture_noise.hpp"
#include "estimator/photograph/retarget.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

constexpr Turbidity kTaken{8.0}, kThinner{3.0}, kThicker{16.0};
constexpr double kLargestGain = 5.0;  // of pictures that went through a JPEG encoder

Image<Rgb8> pixels_of(const Camera& camera, const Image<glm::vec3>& light) {
  Image<Rgb8> picture(light.width(), light.height());
  for (std::size_t i = 0; i < picture.elements().size(); ++i)
    picture.elements()[i] = Rgb8(glm::round(
        255.0 * glm::clamp(camera.response.to_encoded(glm::dvec3(light.elements()[i])), glm::dvec3(0), glm::dvec3(1))));
  return picture;
}

// Percentage of pixels with a channel at 0.
double black_percent(const Image<Rgb8>& picture) {
  const auto black = std::ranges::count_if(picture.elements(), [](const Rgb8& p) {
    return std::min({p.r, p.g, p.b}) == 0;
  });
  return 100.0 * static_cast<double>(black) / static_cast<double>(picture.elements().size());
}

// Change of the upper tenth of the picture, sky or the thickest haze, in levels of 255.
double top_changed(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  glm::dvec3 sum{0.0};
  const int rows = one.height() / 10;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < one.width(); ++x) sum += glm::dvec3(one.at(x, y)) - glm::dvec3(other.at(x, y));
  sum /= rows * one.width();
  return std::max({std::abs(sum.r), std::abs(sum.g), std::abs(sum.b)});
}

}  // namespace

Section classic_section(const ReportOptions& options) {
  Section section("classic", "Hazy photographs without distances");
  section.say(
      "The photographs that papers on dehazing show. Nobody measured their distances or their air, so there is no "
      "truth to compare with; these pictures are for visual inspection. Distances are guessed from the haze itself "
      "(every neighbourhood is taken to hold something black in some channel, in linear light; edges by the guided "
      "filter); the light from infinity is the sky's where some was found, else the thickest haze's; the haze is taken "
      "for grey, as thick haze of cities is: with M's, which takes more of blue, they come out yellow. 'As taken' is "
      "called T 8; only the ratio to 3 and 16 means anything.");
  const auto folder = options.shared_data / "haze" / "classic";
  if (!std::filesystem::exists(folder)) {
    section.finding(Finding::skipped, fmt::format("{}: not there.", folder.string()));
    return section;
  }
  std::vector<std::string> names{"aerial.png", "canon.jpg", "cityscape.png", "tiananmen.png"};
  if (options.quick) names = {"tiananmen.png"};
  const Camera camera;  // sRGB, all of it: where it looks does not matter to a guess
  std::vector<std::vector<std::string>> rows;
  double blackest = 0.0;
  for (const auto& name : names) {
    const auto photograph = read_photograph(folder / name);
    if (!photograph) {
      section.finding(Finding::skipped, photograph.error().message);
      continue;
    }
    const auto& encoded = photograph->encoded;
    const auto source = to_rgb8(*photograph);
    Image<glm::vec3> light(encoded.width(), encoded.height()), relative = light;
    for (std::size_t i = 0; i < light.elements().size(); ++i)
      light.elements()[i] = glm::vec3(camera.response.to_light(glm::dvec3(encoded.elements()[i])));
    const auto sky = segment_sky(source);
    const auto from_infinity = light_of_haze(light, encoded, sky.visible ? sky.sky : Image<std::uint8_t>{});
    for (std::size_t i = 0; i < light.elements().size(); ++i)
      relative.elements()[i] = light.elements()[i] / from_infinity.elements()[i];
    const auto nodes = grey_attenuation_nodes();
    const RetargetGeometry depth{
        depth_from_haze(relative, encoded, nodes, ScatteringModel::morales2017, kTaken), {}, 0.0};
    RetargetHints parts;
    parts.clean = without_noise(encoded, noise_of(encoded));
    for (auto& pixel : parts.clean.elements()) pixel = glm::vec3(camera.response.to_light(glm::dvec3(pixel)));
    ContactSheet sheet;
    sheet.add(source, "as taken");
    std::vector<std::string> row{name, fmt::format("{:.1f} %", black_percent(source))};
    for (const auto& target : {std::optional<Turbidity>{}, std::optional{kThinner}, std::optional{kThicker}}) {
      RetargetLimits how;
      how.largest_gain = kLargestGain;
      const auto made = retarget(light, depth, {kTaken, from_infinity}, {target, from_infinity}, nodes, how, parts);
      const auto pixels = pixels_of(camera, made.light);
      sheet.add(pixels, target ? fmt::format("T {:g}", target->value) : "without haze");
      if (target) continue;
      row.push_back(fmt::format("{:.1f} %", black_percent(pixels)));
      row.push_back(fmt::format("{:.1f}", top_changed(pixels, source)));
      row.push_back(fmt::format("{:.0f} %", 100.0 * made.too_faint_fraction));
      blackest = std::max(blackest, black_percent(pixels) - black_percent(source));
      section.figure(name + ".top_changed", top_changed(pixels, source));
    }
    rows.push_back(std::move(row));
    section.picture(sheet.drawn(2), name, 1000);
  }
  section.table({"picture", "a channel at 0, as taken", "without haze", "upper tenth changed, of 255",
                 "too faint to restore wholly"},
                rows);
  section.figure("black_percent_added", blackest);
  section.finding(
      blackest < 1.0 ? Finding::reproduced : Finding::differs,
      fmt::format("dehazed and re-hazed by one path, which drives no more than {:.1f} % of a picture to black.",
                  blackest));
  section.say(
      "What these pictures cannot show is whether the air is right: a white wall passes for haze, and no distance in "
      "them is measured. With measured distances see the generated scenes.");
  return section;
}

}  // namespace kasumi::paper
