// Landmarks against real air: towers over a city, whose extinction is known from all of their facades together, and a
// road beside a visibility meter. Without ../shared/data/real-air it is skipped.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "base/statistics.hpp"
#include "calib/colour/camera_saturation.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/lab/photographs/visibility_series.hpp"
#include "pipeline/site/config/descriptions.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
#include "tests/paper/landmark_table.hpp"
#include "tests/pipeline/lab/photographs/truth_table.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr const char* kPrinted = "`test_air_truth_towers`";

struct Seen {
  std::string name;
  std::vector<ContrastReading> readings;
  std::vector<glm::dvec3> sky;  // linear light of each landmark's sky box
};

struct SeenSite {
  Camera camera;
  std::optional<LandmarkWatch> watch;
  std::vector<Seen> pictures;
  TruthTable truth;

  std::vector<std::vector<ContrastReading>> readings(std::size_t every = 1) const {
    std::vector<std::vector<ContrastReading>> all;
    for (std::size_t t = 0; t < pictures.size(); t += every) all.push_back(pictures[t].readings);
    return all;
  }
  std::optional<double> known(std::size_t t, const char* column) const {
    const auto& text = truth.at(pictures[t].name).at(column);
    return text.empty() ? std::nullopt : std::optional(std::stod(text));
  }
  std::vector<std::size_t> landmarks(const std::function<bool(const ContrastLandmark&)>& those) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < watch->landmarks().size(); ++i)
      if (those(watch->landmarks()[i])) found.push_back(i);
    return found;
  }
};

glm::dvec3 mean_light(const Camera& camera, const Image<glm::vec3>& encoded, const LandmarkBox& box) {
  glm::dvec3 sum{0};
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) sum += camera.light_at({x, y}, glm::dvec3(encoded.at(x, y)));
  return sum / static_cast<double>(box.width * box.height);
}

// Empty: the data are not there.
std::optional<SeenSite> site_of(const std::string& name) {
  const auto folder = shared_data_folder() / "real-air" / name;
  if (!std::filesystem::exists(folder)) return std::nullopt;
  SeenSite site;
  site.truth = read_truth_table(folder / "truth.csv");
  for (const auto& [picture, row] : site.truth) {
    const auto photograph = read_photograph(folder / (picture + ".jpg"));
    if (!photograph) continue;
    const int width = photograph->encoded.width(), height = photograph->encoded.height();
    if (!site.watch) {
      auto read = read_landmark_file(folder / "landmarks.toml", width, height).value();
      site.camera = read.scene.value_or(plain_camera(width, height, from_degrees(50.0), Radians{0.0}));
      site.watch.emplace(site.camera, read.altitude_m, std::move(read.landmarks));
    }
    Seen seen{picture, site.watch->read(site.camera, photograph->encoded), {}};
    for (const auto& landmark : site.watch->landmarks())
      seen.sky.push_back(mean_light(site.camera, photograph->encoded, landmark.sky.value()));
    site.pictures.push_back(std::move(seen));
  }
  return site;
}

// Both are read once.
const std::optional<SeenSite>& milan() {
  static const auto site = site_of("milan");
  return site;
}
const std::optional<SeenSite>& road() {
  static const auto site = site_of("road");
  return site;
}

bool far(const ContrastLandmark& landmark) {
  return landmark.distance_m > 4000.0;
}

double share_of(int of, int all) {
  return all > 0 ? static_cast<double>(of) / all : 0.0;
}

TEST(AirTruthTowers, NearAndFarOnesTellTheSame) {
  if (!milan()) GTEST_SKIP() << "no shared data: real-air/milan";
  const auto& site = *milan();
  const auto readings = site.readings();
  const auto near = site.landmarks([](const auto&one) { return !far(one); }), distant = site.landmarks(far);
  const auto by_near = site.watch->estimate_all(readings, distant), by_far = site.watch->estimate_all(readings, near);
  int alike = 0, told = 0, told_alike = 0;
  for (std::size_t t = 0; t < readings.size(); ++t) {
    const auto &one = by_near[t].extinction(), &other = by_far[t].extinction();
    if (one.landmarks == 0 || other.landmarks == 0) continue;
    const bool same = std::abs(std::log(one.per_m / other.per_m)) <= std::log(1.2);
    alike += same;
    if (one.kind != ExtinctionKind::value || other.kind != ExtinctionKind::value) continue;
    ++told;
    told_alike += same;
  }
  const double share = share_of(alike, static_cast<int>(readings.size()));
  fmt::print("near and far towers within 20 %: {} of {} pictures; {} of {} where both give a value\n", alike,
             readings.size(), told_alike, told);
  figure_row("real-landmarks",
             {"near and far towers within 20 %", fmt::format("{:.0f} %", 100.0 * share), ">= 45 %", kPrinted});
  EXPECT_GE(share, 0.45);
}

TEST(AirTruthTowers, ValuesAndBoundsAreAsSureAsTheySay) {
  if (!milan()) GTEST_SKIP() << "no shared data: real-air/milan";
  const auto& site = *milan();
  std::vector<double> all_ratios;
  for (const std::size_t every : {1U, 2U, 4U, 8U}) {
    const auto airs = site.watch->estimate_all(site.readings(every));
    int values = 0, within = 0, within_two = 0, bounds = 0, contradicted = 0;
    std::vector<double> ratios, offs, sigmas;
    for (std::size_t k = 0; k < airs.size(); ++k) {
      const auto known = site.known(k * every, "joint_g_per_km");
      const auto& found = airs[k].extinction();
      if (!known || found.kind == ExtinctionKind::nothing) continue;
      const double truth = 1e-3 * *known;
      ratios.push_back(found.per_m / truth);
      if (found.kind == ExtinctionKind::value) {
        ++values;
        const double off = std::abs(found.per_m - truth) / found.sigma_per_m;
        within += off <= 1.0;
        within_two += off <= 2.0;
        sigmas.push_back(1e3 * found.sigma_per_m);
        offs.push_back(1e3 * (found.per_m - truth));
      } else {
        ++bounds;
        contradicted +=
            found.kind == ExtinctionKind::at_most ? truth > found.highest_per_m : truth < found.lowest_per_m;
      }
    }
    all_ratios.push_back(median(ratios));
    fmt::print(
        "{} pictures: told over known {:.3f}; values {}, within 1 sigma {:.0f} %, within 2 {:.0f} %; bounds {}, "
        "contradicted {}; off {:.4f}, sigma {:.4f} per km in the median\n",
        airs.size(), all_ratios.back(), values, 100.0 * share_of(within, values), 100.0 * share_of(within_two, values),
        bounds, contradicted, median(offs), median(sigmas));
    if (every == 1)
      figure_row("real-landmarks", {"towers' values within 1 sigma; bounds contradicted",
                                    fmt::format("{:.0f} %; {:.0f} %", 100.0 * share_of(within, values),
                                                100.0 * share_of(contradicted, bounds)),
                                    "58 to 78 %; <= 4 %", kPrinted});
  }
  const auto [least, most] = std::ranges::minmax(all_ratios);
  figure_row("real-landmarks", {"told over known, 20 to 166 pictures: from, to", figure_range(least, most, 2),
                                "within .10 of each other", kPrinted});
  EXPECT_LE(most / least, 1.1);
}

// The program's way from the aerosol that all landmarks tell to a dull dark facade behind it: as if the camera left
// colours as they are, and with the saturation that the same landmarks have taught.
TEST(AirTruthTowers, DarkFacadesAreDrawnInTheCamerasColours) {
  if (!milan()) GTEST_SKIP() << "no shared data: real-air/milan";
  const auto& site = *milan();
  const auto airs = site.watch->estimate_all(site.readings());
  const glm::dvec3 nm = site.watch->colours().wavelength_nm(), own{0.05};  // of the horizon's light
  std::array<std::array<std::vector<double>, 3>, 2> off;
  for (std::size_t t = 0; t < airs.size(); ++t)
    for (std::size_t i = 0; i < site.watch->landmarks().size(); ++i) {
      const auto& landmark = site.watch->landmarks()[i];
      const auto& reading = site.pictures[t].readings[i];
      constexpr std::array kDull{"pirelli", "galfa", "gioia22-face", "solaria-dark", "bosco"};
      if (std::ranges::find(kDull, landmark.name) == kDull.end() || !reading.usable || reading.contrast.g < 0.1 ||
          airs[t].aerosol.kind != ExtinctionKind::value)
        continue;
      glm::dvec3 light{0.0};
      for (int c = 0; c < 3; ++c) {
        const double per_m = rayleigh_per_m(ScatteringModel::aerosol, nm[c]) +
                             airs[t].aerosol.per_m * std::pow(nm[c] / 550.0, -airs[t].aerosol.angstrom_exponent);
        const double left = std::exp(-per_m * landmark.distance_m);
        light[c] = 1.0 - left + left * own[c];
      }
      const glm::dvec3& sky = site.pictures[t].sky[i];
      const auto encoded = [&](const glm::dvec3& shown) {
        return 255.0 * site.camera.response.to_encoded(glm::clamp(shown, 0.0, 1.0));
      };
      const glm::dvec3 seen = encoded(sky * (1.0 - reading.contrast));
      for (const bool learnt : {false, true}) {
        const double saturation = learnt ? saturation_believed(airs[t].camera) : 1.0;
        const auto drawn = encoded(with_saturation(with_saturation(sky, 1.0 / saturation) * light, saturation));
        for (int c = 0; c < 3; ++c) off[learnt ? 1 : 0][static_cast<std::size_t>(c)].push_back(drawn[c] - seen[c]);
      }
    }
  ASSERT_FALSE(off[0][0].empty());
  std::array<std::string, 2> told;
  std::array<double, 2> worst{};
  for (std::size_t k = 0; k < 2; ++k) {
    std::array<double, 3> bias{};
    for (std::size_t c = 0; c < 3; ++c) {
      bias[c] = median(off[k][c]);
      worst[k] = std::max(worst[k], std::abs(bias[c]));
    }
    told[k] = fmt::format("{:+.1f} {:+.1f} {:+.1f}", bias[0], bias[1], bias[2]);
  }
  const auto& camera = airs.back().camera;
  fmt::print("dull dark facades drawn, bias R G B of 255: {} -> {}; saturation {:.2f} +- {:.2f}, {} facades\n", told[0],
             told[1], camera.chroma, camera.chroma * camera.log_sigma, off[0][0].size());
  figure_row("real-landmarks",
             {"dull dark facades drawn, bias of R, G, B: the camera's colours not known", told[0], "", kPrinted});
  figure_row("real-landmarks", {"the same, its saturation learnt", told[1], "each <= 5", kPrinted});
  EXPECT_LE(worst[1], 5.0);
  EXPECT_LE(worst[1], 0.6 * worst[0]);
}

// The curve of this camera is unknown: halves of the days have to agree about it.
TEST(AirTruthTowers, HalvesOfTheDaysTellTheCamerasToneAlike) {
  if (!milan()) GTEST_SKIP() << "no shared data: real-air/milan";
  const auto& site = *milan();
  std::array<std::vector<std::vector<ContrastReading>>, 3> parts;  // all; two halves
  std::string day;
  std::size_t half = 1;
  for (const auto& picture : site.pictures) {
    if (const auto today = picture.name.substr(0, 8); today != day) day = today, half = 3 - half;
    parts[0].push_back(picture.readings);
    parts[half].push_back(picture.readings);
  }
  std::array<ContrastTone, 3> told;
  std::array<std::string, 3> text;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    told[k] = site.watch->estimate_all(parts[k]).back().tone;
    ASSERT_TRUE(told[k].known());
    text[k] = fmt::format("{:.2f} +- {:.2f}", told[k].exponent, told[k].exponent * told[k].log_sigma);
  }
  fmt::print("tone exponent {}; by halves of the days {}, {}\n", text[0], text[1], text[2]);
  figure_row("real-landmarks", {"the camera's tone exponent; by every other day, by those between",
                                fmt::format("{}; {}; {}", text[0], text[1], text[2]), "", kPrinted});
  EXPECT_LE(std::abs(std::log(told[1].exponent / told[2].exponent)),
            2.0 * std::hypot(told[1].log_sigma, told[2].log_sigma));
}

// "2020-02-01-08-45" -> of the month.
int minute_of(const std::string& name) {
  return 1440 * std::stoi(name.substr(8, 2)) + 60 * std::stoi(name.substr(11, 2)) + std::stoi(name.substr(14, 2));
}

struct Pairs {
  int alike = 0, all = 0;
  void add(double one, double other) {
    ++all;
    alike += one >= 0.5 * other && one <= 2.0 * other;
  }
  double share() const { return share_of(alike, all); }
};

// A bound is no value: it is held to its word, and what is likeliest within it is compared. Meter and picture both end
// at 20 km, where the meter does.
TEST(AirTruthTowers, VisibilityOnARoadIsTheMeters) {
  if (!road()) GTEST_SKIP() << "no shared data: real-air/road";
  constexpr double kMeterEnds_m = 20000.0, kFog_m = 5000.0;
  const auto& site = *road();
  const auto airs = site.watch->estimate_all(site.readings());
  std::vector<double> ours, measured, biases;
  Pairs all, in_fog, meters_own, as_values;
  int values = 0, within = 0, bounds = 0, contradicted = 0;
  for (std::size_t t = 0; t < airs.size(); ++t) {
    const double meter = *site.known(t, "visibility_m");
    const auto& found = airs[t].extinction();
    if (t > 0 && meter < kFog_m && minute_of(site.pictures[t].name) - minute_of(site.pictures[t - 1].name) == 3)
      meters_own.add(*site.known(t - 1, "visibility_m"), meter);
    if (found.kind == ExtinctionKind::nothing) {
      for (auto* pairs : {&all, &as_values}) ++pairs->all;
      continue;
    }
    const double likeliest_m = std::min(kMeteorologicalOpticalRange / found.per_m, kMeterEnds_m);
    ours.push_back(kMeteorologicalOpticalRange / found.per_m);
    measured.push_back(meter);
    all.add(likeliest_m, meter);
    if (meter < kFog_m) in_fog.add(likeliest_m, meter);
    as_values.add(airs[t].optical_range_m(), meter);
    if (meter >= 200.0 && meter <= kFog_m) biases.push_back(ours.back() / meter);
    const double truth = kMeteorologicalOpticalRange / meter;
    if (found.kind == ExtinctionKind::value) {
      ++values;
      within += std::abs(found.per_m - truth) <= found.sigma_per_m;
    } else {
      ++bounds;
      contradicted += found.kind == ExtinctionKind::at_most ? truth > found.highest_per_m : truth < found.lowest_per_m;
    }
  }
  const double rank = spearman(ours, measured);
  fmt::print(
      "road: Spearman {:.3f}; within a factor of 2 {:.2f}, in fog {:.2f} (the meter's own {:.2f}), bounds as values "
      "{:.2f}; ours over the meter's from 200 m to 5 km {:.2f}; values {}, within 1 sigma {:.0f} %; bounds {}, "
      "contradicted {}\n",
      rank, all.share(), in_fog.share(), meters_own.share(), as_values.share(), median(biases), values,
      100.0 * share_of(within, values), bounds, contradicted);
  figure_row("real-landmarks", {"road: Spearman", figure_text(rank, 2), ">= .78", kPrinted});
  figure_row("real-landmarks", {"road: the likeliest within a factor of 2, both at most the meter's 20 km",
                                figure_text(all.share(), 2), ">= .60", kPrinted});
  figure_row("real-landmarks",
             {"road: the likeliest where the meter says under 5 km", figure_text(in_fog.share(), 2),
              fmt::format("its own reading of 3 minutes before: {}", figure_text(meters_own.share(), 2)), kPrinted});
  figure_row("real-landmarks", {"road: within a factor of 2, each bound taken for the value",
                                figure_text(as_values.share(), 2), "", kPrinted});
  figure_row("real-landmarks",
             {"road: over the meter's, 200 m to 5 km", figure_text(median(biases), 2), ".8 to 1.25", kPrinted});
  figure_row("real-landmarks", {"road: values within 1 sigma; bounds contradicted",
                                fmt::format("{:.0f} %; {:.0f} %", 100.0 * share_of(within, values),
                                            100.0 * share_of(contradicted, bounds)),
                                "58 to 78 %; <= 4 %", kPrinted});
  EXPECT_GE(rank, 0.78);
  EXPECT_GE(all.share(), 0.6);
  EXPECT_LE(share_of(contradicted, bounds), 0.04);
}

}  // namespace
}  // namespace kasumi
