// How accurate must an installation be? One recording of known truth is replayed with one camera value at a time wrong
// by a stated amount; the effect on T and on the building in the picture is printed as the table of
// docs/calibration.md. The accuracy that `kasumi calibrate` reaches must be sufficient: those rows are held to a limit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using std::chrono::hours;
using std::chrono::minutes;

constexpr double kDistance_m = 3500.0;
constexpr int kWidth_px = 320;
constexpr double kFieldOfView_deg = 3.0;
// Size of a pixel across the line of sight at the building.
const double kMetresPerPixel = kDistance_m * std::tan(from_degrees(kFieldOfView_deg).value) / kWidth_px;

using Change = std::function<void(toml::table&)>;

// A fixture.toml with a change.
std::string changed(const std::string& text, const Change& change) {
  auto all = toml::parse(text);
  change(all);
  std::ostringstream out;
  out << all << "\n";
  return out.str();
}

toml::table& table_of(toml::table& all, const std::string& path) {
  return *all.at_path(path).as_table();
}
double number_in(const toml::table& table, const std::string& key) {
  return table[key].value<double>().value();
}

struct Mistake {
  std::string camera, description;
  Change make;
  // Limits for the accuracy that kasumi calibrate reaches: largest change of T, of the building (levels of 255) and of
  // its position.
  struct Limit {
    double turbidity, levels, shift_m;
  };
  std::optional<Limit> limit = {};
};

Mistake plus(const std::string& camera, const std::string& table, const std::string& key, double by,
             const std::string& description, std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](toml::table& all) {
            auto& of = table_of(all, table);
            of.insert_or_assign(key, number_in(of, key) + by);
          },
          limit};
}

// A list, each value multiplied by its factor.
Mistake times(const std::string& camera, const std::string& table, const std::string& key,
              const std::vector<double>& factors, const std::string& description,
              std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](toml::table& all) {
            auto& of = table_of(all, table);
            toml::array list;
            for (std::size_t i = 0; i < factors.size(); ++i)
              list.push_back(of[key][i].value<double>().value() * factors[i]);
            EXPECT_EQ(list.size(), of[key].as_array()->size()) << key;
            of.insert_or_assign(key, list);
          },
          limit};
}

// A sky camera that looks straight up, tilted by this angle.
Mistake tilted(double by_deg, const std::string& description, std::optional<Mistake::Limit> limit = {}) {
  return {"sky", description,
          [=](toml::table& all) {
            auto& sky = table_of(all, "sky");
            sky.insert_or_assign("heading_deg", number_in(sky, "azimuth_up_deg") - 180.0);
            sky.insert_or_assign("pitch_deg", 90.0 - by_deg);
            sky.insert_or_assign("roll_deg", 0.0);
            sky.erase("azimuth_up_deg");
          },
          limit};
}

// sRGB followed by a power: the effect of a wrong response curve on light.
Mistake bent(const std::string& camera, double power, const std::string& description,
             std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](toml::table& all) {
            toml::array table;
            for (int i = 0; i < 256; ++i)
              table.push_back(std::pow(Response::srgb().to_light(glm::dvec3(i / 255.0)).g, power));
            table_of(all, camera).insert_or_assign("response", "table");
            table_of(all, camera).insert_or_assign("response_table", table);
          },
          limit};
}

// Filters whose bell curves are shifted by this many nm from the camera's.
Mistake other_filters(const std::string& camera, double by_nm, const std::string& description) {
  return {camera, description, [=](toml::table& all) {
            const auto path = test_folder(fmt::format("filters-{:+.0f}.csv", by_nm));
            std::string csv = "nm,r,g,b\n";
            for (double nm = 380.0; nm <= 780.0; nm += 5.0) {
              const auto bell = [&](double peak, double width) {
                const double off = (nm - peak - by_nm) / width;
                return std::exp(-0.5 * off * off);
              };
              csv += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", nm, bell(600, 35), bell(540, 40), bell(450, 30));
            }
            must(write_text_file(path, csv));
            table_of(all, camera).insert_or_assign("sensitivity", path.string());
          }};
}

Mistake without(const std::string& camera, const std::string& key, const std::string& description) {
  return {camera, description,
          [=](toml::table& all) { EXPECT_EQ(table_of(all, camera).erase(key), 1u) << camera << " " << key; }};
}

std::vector<Mistake> mistakes() {
  using Limit = Mistake::Limit;
  return {
      plus("sky", "sky", "azimuth_up_deg", 0.05, "turned by .05 deg (`calibrate sky`)", Limit{.05, .3, .05}),
      plus("sky", "sky", "azimuth_up_deg", 1.0, "turned by 1 deg"),
      plus("sky", "sky", "azimuth_up_deg", 5.0, "turned by 5 deg"),
      tilted(0.05, "tilted by .05 deg (`calibrate sky`)", Limit{.05, .3, .05}),
      tilted(1.0, "tilted by 1 deg"),
      tilted(3.0, "tilted by 3 deg"),
      plus("sky", "sky.lens", "focal_px", 0.003 * 73.8, "focal length .3 % too long (`calibrate sky`)",
           Limit{.05, .3, .05}),
      plus("sky", "sky.lens", "focal_px", 0.03 * 73.8, "focal length 3 % too long"),
      times("sky", "sky.lens", "centre_px", {1.008, 1.0}, "centre 1 px off (of 240)"),
      times("sky", "sky.lens", "centre_px", {1.033, 1.0}, "centre 4 px off (of 240)"),
      bent("sky", 1.01,
           "response: a power of 1.01 too much, 5.7 % of light 8 stops down (`calibrate response` reaches 1 %)",
           Limit{.1, .5, .05}),
      bent("sky", 1.1, "response: a power of 1.1 too much"),
      bent("sky", 0.9, "response: a power of .9 too much"),
      times("sky", "sky.vignetting", "coefficients", {1.05, 1.0, 1.0},
            "vignetting 1 % off at the rim (`calibrate response`)", Limit{.1, .5, .05}),
      without("sky", "vignetting", "vignetting of 19 % at the rim left out"),
      without("sky", "mask", "mask left out"),
      times("sky", "sky", "white_balance", {1.05, 1.0, 0.95}, "white balance 5 % off"),
      other_filters("sky", 10.0, "filters 10 nm off"),
      plus("site", "site", "longitude_deg", 0.25, "clock 1 min off, or longitude .25 deg"),
      plus("site", "site", "longitude_deg", 3.75, "clock 15 min off"),
      plus("site", "site", "altitude_m", 100.0, "altitude 100 m off"),
      plus("scene", "scene", "heading_deg", 0.02, "turned by .02 deg (`calibrate scene`)", Limit{.01, 20.0, 1.4}),
      plus("scene", "scene", "heading_deg", 0.2, "turned by .2 deg"),
      plus("scene", "scene", "pitch_deg", 0.02, "pitched by .02 deg (`calibrate scene`)", Limit{.01, 20.0, 1.4}),
      plus("scene", "scene", "pitch_deg", 0.2, "pitched by .2 deg"),
      plus("scene", "scene", "roll_deg", 0.5, "rolled by .5 deg"),
      times("scene", "scene.lens", "focal_px", {1.01, 1.01}, "focal length 1 % too long"),
      bent("scene", 1.01,
           "response: a power of 1.01 too much, 5.7 % of light 8 stops down (`calibrate response` reaches 1 %)",
           Limit{.01, 1.0, .1}),
      bent("scene", 1.1, "response: a power of 1.1 too much"),
      bent("scene", 0.9, "response: a power of .9 too much"),
      without("scene", "vignetting", "vignetting of 5 % left out"),
      times("scene", "scene", "white_balance", {1.05, 1.0, 0.95}, "white balance 5 % off"),
      other_filters("scene", 10.0, "filters 10 nm off"),
  };
}

struct Outcome {
  double turbidity = std::numeric_limits<double>::quiet_NaN();  // of this frame; not a number: none
  Image<glm::vec3> picture;
};

Outcome played(const std::filesystem::path& fixture, const std::string& name) {
  const auto out = test_folder(name + "-out");
  const auto summary = must(replay({fixture, out, false, false, 1, {}}));
  Outcome outcome;
  if (summary->last && summary->last->estimate.usable) outcome.turbidity = summary->last->estimate.turbidity.value;
  outcome.picture = read_photograph(out / "frame-000000.png").value().encoded;
  return outcome;
}

// The same recording under another fixture.toml.
std::filesystem::path described(const std::filesystem::path& recording, const std::string& toml,
                                const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (const auto& entry : std::filesystem::directory_iterator(recording))
    if (entry.path().filename() != "fixture.toml")
      std::filesystem::create_symlink(std::filesystem::absolute(entry.path()), folder / entry.path().filename());
  must(write_text_file(folder / "fixture.toml", toml));
  return folder;
}

// The pixels where two pictures differ by more than a level, and their centre.
struct Silhouette {
  std::vector<glm::ivec2> pixels;
  glm::dvec2 middle{};
};
Silhouette silhouette(const Image<glm::vec3>& with, const Image<glm::vec3>& bare) {
  Silhouette found;
  for (int y = 0; y < with.height(); ++y)
    for (int x = 0; x < with.width(); ++x) {
      const glm::dvec3 off = glm::abs(with.at(x, y) - bare.at(x, y));
      if (std::max({off.r, off.g, off.b}) < 1.5 / 255.0) continue;
      found.pixels.push_back({x, y});
      found.middle += glm::dvec2(x, y);
    }
  found.middle /= std::max<double>(1.0, static_cast<double>(found.pixels.size()));
  return found;
}

struct Effect {
  double turbidity = 0.0, levels = 0.0, shift_m = 0.0;
};

class Recording {
 public:
  Recording(const std::string& name, double turbidity, Utc start) : name_(name) {
    auto recipe = small("papers-noon", 1);
    recipe.scene_width = kWidth_px;
    recipe.scene_height = 180;
    recipe.sky_size = 240;
    recipe.turbidity = recipe.turbidity_end = turbidity;
    recipe.start_utc = start;
    recipe.outlook.distance_m = kDistance_m;
    recipe.outlook.field_of_view_deg = kFieldOfView_deg;
    folder_ = recorded(recipe, name);
    toml_ = read_text_file(folder_ / "fixture.toml").value();
    right_ = played(folder_, name);
    const auto away = changed(toml_, [](toml::table& all) {
      auto& object = table_of(all, "object");
      object.insert_or_assign("north_m", -number_in(object, "north_m"));
    });
    bare_ = played(described(folder_, away, name + "-bare"), name).picture;
    building_ = silhouette(right_.picture, bare_);
    EXPECT_NEAR(right_.turbidity, turbidity, 0.1) << name;
    EXPECT_GT(building_.pixels.size(), 200u) << name;
  }

  Effect of(const Mistake& mistake) const {
    const auto outcome = played(described(folder_, changed(toml_, mistake.make), name_ + "-wrong"), name_);
    Effect effect{outcome.turbidity - right_.turbidity, 0.0, 0.0};
    for (const auto& p : building_.pixels) {
      const glm::dvec3 off = glm::abs(outcome.picture.at(p.x, p.y) - right_.picture.at(p.x, p.y));
      effect.levels += 255.0 / 3.0 * (off.r + off.g + off.b) / static_cast<double>(building_.pixels.size());
    }
    effect.shift_m = kMetresPerPixel * glm::distance(silhouette(outcome.picture, bare_).middle, building_.middle);
    return effect;
  }
  const std::string& toml() const { return toml_; }

 private:
  std::string name_, toml_;
  std::filesystem::path folder_;
  Outcome right_;
  Image<glm::vec3> bare_;
  Silhouette building_;
};

std::string text_of(const Effect& effect) {
  const auto turbidity = std::isfinite(effect.turbidity) ? fmt::format("{:+.2f}", effect.turbidity) : "refused";
  return fmt::format("{} | {:.1f} | {:.1f}", turbidity, effect.levels, effect.shift_m);
}

// A quarter of the table is held to limits; the rest is for information.
TEST(CalibrationErrors, OfTheSizeThatCalibrateReachesAreInvisible) {
  const Utc day(std::chrono::sys_days(std::chrono::year{2026} / 10 / 20));
  const Recording high("mistakes-high", 2.4, day + hours(2) + minutes(40)),
      low("mistakes-low", 5.0, day + hours(6) + minutes(45));
  fmt::print(
      "| camera | what is wrong | T 2.4, noon: T | building, of 255 | shift, m | T 5, sun 17 deg high: T | "
      "building, of 255 | shift, m |\n|---|---|---|---|---|---|---|---|\n");
  auto limited = mistakes();
  std::erase_if(limited, [](const Mistake& one) { return !one.limit; });
  for (const Mistake& mistake : figure_cases("mistakes", limited, mistakes())) {
    const Effect noon = high.of(mistake), evening = low.of(mistake);
    fmt::print("| {} | {} | {} | {} |\n", mistake.camera, mistake.description, text_of(noon), text_of(evening));
    if (!mistake.limit) continue;
    for (const Effect& effect : {noon, evening}) {
      EXPECT_LE(std::abs(effect.turbidity), mistake.limit->turbidity) << mistake.camera << " " << mistake.description;
      EXPECT_LE(effect.levels, mistake.limit->levels) << mistake.camera << " " << mistake.description;
      EXPECT_LE(effect.shift_m, mistake.limit->shift_m) << mistake.camera << " " << mistake.description;
    }
  }
}

// A camera that looks straight up can be described in two ways; the rows with a tilt rely on it.
TEST(CalibrationErrors, AnUntiltedCameraIsTheSameInBothDescriptions) {
  const Recording recording("mistakes-none", 3.0,
                            Utc(std::chrono::sys_days(std::chrono::year{2026} / 10 / 20)) + hours(1));
  const Effect none = recording.of(tilted(0.0, "not tilted"));
  EXPECT_NEAR(none.turbidity, 0.0, 1e-6);
  EXPECT_LE(none.levels, 0.01);
}

}  // namespace
}  // namespace kasumi
