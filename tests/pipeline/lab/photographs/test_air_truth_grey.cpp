// The colours of grey things in the sun and in the shade before real towers, as the model of the light has them and once
// other grey things in view have been asked. Without ../shared/data/real-air it is skipped.
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "base/statistics.hpp"
#include "estimator/light/card_light.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/lab/photographs/truth_table.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr double kAltitude_m = 165.0, kLooks_deg = 206.4, kFocal_px = 1680.0;

struct GreyThing {
  int x, y, width, height;
  bool roof;
};
// Pieces of roofs and parapets, some 100 m away: the first two are the cards, the others are judged.
constexpr std::array<GreyThing, 6> kGreyThings{{{780, 219, 45, 3, true},
                                                {700, 231, 60, 6, false},
                                                {598, 222, 44, 3, true},
                                                {1335, 216, 45, 4, true},
                                                {600, 232, 60, 5, false},
                                                {1320, 228, 70, 8, false}}};
// That the cards were looked at on.
const std::set<std::string> kDaysOfDevelopment{"20250407", "20250428", "20250430", "20250612"};

glm::dvec3 mean_of(const Camera& camera, const Image<glm::vec3>& encoded, int left, int top, int width, int height) {
  glm::dvec3 sum{0.0};
  for (int y = top; y < top + height; ++y)
    for (int x = left; x < left + width; ++x) sum += camera.light_at({x, y}, glm::dvec3(encoded.at(x, y)));
  return sum / static_cast<double>(width * height);
}

Direction towards_column(double x) {
  return direction_from(from_degrees(88.7), from_degrees(kLooks_deg) + Radians{std::atan((x - 959.5) / kFocal_px)});
}

LightCard card_of(const GreyThing& thing) {
  LightCard card;
  card.grey = true;
  card.reflectance = glm::dvec3{kGreyReflectance};
  card.normal = thing.roof ? Direction{0, 0, 1} : direction_from(from_degrees(90.0), from_degrees(20.0));
  return card;
}

// Red and blue of a grey thing as bright as it is seen, less as they are seen, of 255.
struct ColourOff {
  std::vector<double> red, blue;
  double median_size() const {
    std::vector<double> all;
    for (const auto* channel : {&red, &blue})
      for (const double one : *channel) all.push_back(std::abs(one));
    return median(all);
  }
  std::string text() const { return fmt::format("{:+.1f}, {:+.1f}", median(red), median(blue)); }
};

TEST(AirTruthGrey, ThingsInSunAndShadeHaveTheColoursThatOthersTell) {
  const auto folder = shared_data_folder() / "real-air" / "milan";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data: real-air/milan";
  const Camera camera = plain_camera(1920, 240, from_degrees(59.5), Radians{0.0});
  std::array<std::array<ColourOff, 2>, 2> off;  // [by cards][in the sun]
  int pictures = 0;
  for (const auto& [name, row] : read_truth_table(folder / "truth.csv")) {
    const double azimuth_deg = std::stod(row.at("sun_azimuth_deg")), high_deg = std::stod(row.at("sun_elevation_deg"));
    // Parapets look north: in the shade.
    if (row.at("class") != "clear" || high_deg < 20.0 || azimuth_deg < 150.0 || azimuth_deg > 260.0) continue;
    if (kDaysOfDevelopment.contains(name.substr(0, 8))) continue;
    const auto photograph = read_photograph(folder / (name + ".jpg"));
    ASSERT_TRUE(photograph) << name;
    ++pictures;
    const double per_m = std::max(0.0, 1e-3 * std::stod(row.at("joint_g_per_km")) - 1.13e-5);
    const AirState air{Aerosol{per_m * 1200.0 * std::exp(kAltitude_m / 1200.0), 1.3, AerosolKind::continental}};
    const auto sun = direction_from(from_degrees(90.0 - high_deg), from_degrees(azimuth_deg));
    const Daylight daylight(camera, air, sun, {SkyCondition::clear, 0.2, kAltitude_m, DaylightModel::dome});
    std::vector<CardReading> cards;
    for (std::size_t i = 0; i < kGreyThings.size(); ++i) {
      const auto& thing = kGreyThings[i];
      const auto seen = mean_of(camera, photograph->encoded, thing.x, thing.y, thing.width, thing.height);
      const auto sky = thing.x < 1000 ? mean_of(camera, photograph->encoded, 740, 130, 30, 28)
                                      : mean_of(camera, photograph->encoded, 1260, 130, 60, 25);
      const auto card = card_of(thing);
      const auto towards = towards_column(thing.x);
      if (i < 2) cards.push_back(card_reading(card, seen / sky, towards, daylight));
      if (i < 2) continue;
      for (const bool by_cards : {false, true}) {
        const auto factors = by_cards ? factors_by_cards(cards) : LightFactors{};
        const auto& light = daylight.on_object();
        const double incidence = std::max(0.0, glm::dot(card.normal, light.sun_direction));
        const glm::dvec3 grey =
            sky *
            (factors.sun * incidence * light.sun_irradiance + factors.around * irradiance(light.around, card.normal)) /
            daylight.airlight(towards);
        const auto drawn = 255.0 * camera.response.to_encoded(glm::clamp(grey * (seen.g / grey.g), 0.0, 1.0));
        const auto as_seen = 255.0 * camera.response.to_encoded(seen);
        auto& one = off[by_cards ? 1 : 0][thing.roof ? 1 : 0];
        one.red.push_back(drawn.r - as_seen.r);
        one.blue.push_back(drawn.b - as_seen.b);
      }
    }
  }
  ASSERT_GE(pictures, 10);
  fmt::print("{} clear pictures of other days\n", pictures);
  for (const bool lit : {true, false}) {
    const auto& model = off[0][lit ? 1 : 0];
    const auto& told = off[1][lit ? 1 : 0];
    fmt::print("grey {}: red, blue off {} by the model, {} by cards; size {:.1f} -> {:.1f}\n",
               lit ? "in the sun" : "in the shade", model.text(), told.text(), model.median_size(), told.median_size());
    const std::string what = lit ? "grey roofs in the sun" : "grey walls in the shade";
    figure_row("real-grey", {what, std::to_string(told.red.size()), model.text(), figure_text(model.median_size(), 1),
                             told.text(), figure_text(told.median_size(), 1)});
    EXPECT_LT(told.median_size(), model.median_size());
  }
  const auto all = [&](std::size_t by) { return off[by][0].median_size() + off[by][1].median_size(); };
  EXPECT_LT(all(1), 0.85 * all(0));
}

}  // namespace
}  // namespace kasumi
