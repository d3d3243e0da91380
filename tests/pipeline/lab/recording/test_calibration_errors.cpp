// How accurate must an installation be? One recording of known truth is replayed with one camera value at a time wrong
// by a stated amount; the effect on T and on the building in the picture is printed as the table of
// docs/calibration.md. The accuracy that `kasumi calibrate` reaches must be sufficient: those rows are held to a limit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
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

// The lines of a fixture.toml between [table] and the next one.
std::pair<std::size_t, std::size_t> lines_of(const std::string& toml, const std::string& table) {
  const auto header = "[" + table + "]\n";
  const auto at = toml.find(header);
  if (at == std::string::npos) {
    ADD_FAILURE() << "no [" << table << "] in the recording's fixture.toml";
    return {toml.size(), toml.size()};
  }
  const auto end = toml.find("\n[", at + header.size() - 1);
  return {at + header.size(), end == std::string::npos ? toml.size() : end + 1};
}

// Removes `keys` from [table] and inserts `lines`.
std::string edited(std::string toml, const std::string& table, const std::vector<std::string>& keys,
                   const std::string& lines) {
  for (const auto& key : keys) {
    const auto [begin, end] = lines_of(toml, table);
    const auto part = "\n" + toml.substr(begin, end - begin);
    const auto at = part.find("\n" + key + " = ");
    if (at == std::string::npos) {
      ADD_FAILURE() << "no " << key << " in [" << table << "]";
      continue;
    }
    toml.erase(begin + at, part.find('\n', at + 1) - at);
  }
  toml.insert(lines_of(toml, table).first, lines);
  return toml;
}

std::string taken_out(std::string toml, const std::string& table) {
  const auto header = "[" + table + "]\n";
  const auto [begin, end] = lines_of(toml, table);
  return toml.erase(begin - header.size(), end - begin + header.size());
}

double number_of(const std::string& toml, const std::string& table, const std::string& key) {
  const auto [begin, end] = lines_of(toml, table);
  return std::stod(toml.substr(toml.find("\n" + key + " = ", begin - 1) + key.size() + 4));
}
std::vector<double> numbers_of(const std::string& toml, const std::string& table, const std::string& key) {
  const auto [begin, end] = lines_of(toml, table);
  auto at = toml.find("\n" + key + " = [", begin - 1) + key.size() + 5;
  std::vector<double> numbers;
  while (true) {
    std::size_t length = 0;
    numbers.push_back(std::stod(toml.substr(at, 64), &length));
    at += length;
    if (toml[at] == ']') return numbers;
    ++at;
  }
}

struct Mistake {
  std::string camera, description;
  std::function<std::string(const std::string&)> of;  // fixture.toml with it
  // Limits for the accuracy that kasumi calibrate reaches: largest change of T, of the building (levels of 255) and of
  // its position.
  struct Limit {
    double turbidity, levels, shift_m;
  };
  std::optional<Limit> limit;
};

Mistake plus(const std::string& camera, const std::string& table, const std::string& key, double by,
             const std::string& description, std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](const std::string& toml) {
            return edited(toml, table, {key}, fmt::format("{} = {:.10f}\n", key, number_of(toml, table, key) + by));
          },
          limit};
}

// A list, each value multiplied by its factor.
Mistake times(const std::string& camera, const std::string& table, const std::string& key,
              const std::vector<double>& factors, const std::string& description,
              std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](const std::string& toml) {
            auto values = numbers_of(toml, table, key);
            std::string list;
            for (std::size_t i = 0; i < values.size(); ++i)
              list += fmt::format("{}{:.10f}", i == 0 ? "" : ", ", values[i] * factors.at(i));
            return edited(toml, table, {key}, fmt::format("{} = [{}]\n", key, list));
          },
          limit};
}

// A sky camera that looks straight up, tilted by this angle.
Mistake tilted(double by_deg, const std::string& description, std::optional<Mistake::Limit> limit = {}) {
  return {"sky", description,
          [=](const std::string& toml) {
            const double up = number_of(toml, "sky", "azimuth_up_deg");
            return edited(
                toml, "sky", {"azimuth_up_deg"},
                fmt::format("heading_deg = {:.6f}\npitch_deg = {:.6f}\nroll_deg = 0.0\n", up - 180.0, 90.0 - by_deg));
          },
          limit};
}

// sRGB followed by a power: the effect of a wrong response curve on light.
Mistake bent(const std::string& camera, double power, const std::string& description,
             std::optional<Mistake::Limit> limit = {}) {
  return {camera, description,
          [=](const std::string& toml) {
            std::string table;
            for (int i = 0; i < 256; ++i) {
              const double v = i / 255.0;
              const double light = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
              table += fmt::format("{}{:.9f}", i == 0 ? "" : ", ", std::pow(light, power));
            }
            return edited(toml, camera, {"response"},
                          fmt::format("response = \"table\"\nresponse_table = [{}]\n", table));
          },
          limit};
}

// Filters whose bell curves are shifted by this many nm from the camera's.
Mistake other_filters(const std::string& camera, double by_nm, const std::string& description) {
  return {camera,
          description,
          [=](const std::string& toml) {
            const auto path = test_folder(fmt::format("filters-{:+.0f}.csv", by_nm));
            std::string csv = "nm,r,g,b\n";
            for (double nm = 380.0; nm <= 780.0; nm += 5.0) {
              const auto bell = [&](double peak, double width) {
                const double off = (nm - peak - by_nm) / width;
                return std::exp(-0.5 * off * off);
              };
              csv += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", nm, bell(600, 35), bell(540, 40), bell(450, 30));
            }
            if (const auto done = write_text_file(path, csv); !done) ADD_FAILURE() << done.error().message;
            return edited(toml, camera, {}, fmt::format("sensitivity = \"{}\"\n", path.string()));
          },
          {}};
}

Mistake without(const std::string& camera, const std::string& table, const std::string& description) {
  return {camera, description, [=](const std::string& toml) { return taken_out(toml, table); }, {}};
}
Mistake without_key(const std::string& camera, const std::string& key, const std::string& description) {
  return {camera, description, [=](const std::string& toml) { return edited(toml, camera, {key}, ""); }, {}};
}

std::vector<Mistake> mistakes() {
  using Limit = Mistake::Limit;
  const auto ones = std::vector{1.0, 1.0, 1.0};
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
            "vignetting 1 % off at the rim "
            "(`calibrate response`)",
            Limit{.1, .5, .05}),
      without("sky", "sky.vignetting", "vignetting of 19 % at the rim left out"),
      without_key("sky", "mask", "mask left out"),
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
      without("scene", "scene.vignetting", "vignetting of 5 % left out"),
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
  const auto summary = replay({fixture, out, false, false, 1, {}});
  if (!summary) {
    ADD_FAILURE() << summary.error().message;
    return {};
  }
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
  if (const auto done = write_text_file(folder / "fixture.toml", toml); !done) ADD_FAILURE() << done.error().message;
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
    const double north = number_of(toml_, "object", "north_m");
    const auto away = edited(toml_, "object", {"north_m"}, fmt::format("north_m = {:.2f}\n", -north));
    bare_ = played(described(folder_, away, name + "-bare"), name).picture;
    building_ = silhouette(right_.picture, bare_);
    EXPECT_NEAR(right_.turbidity, turbidity, 0.1) << name;
    EXPECT_GT(building_.pixels.size(), 200u) << name;
  }

  Effect of(const Mistake& mistake) const {
    const auto outcome = played(described(folder_, mistake.of(toml_), name_ + "-wrong"), name_);
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
