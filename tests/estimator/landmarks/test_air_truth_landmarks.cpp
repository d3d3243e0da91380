// The aerosol on the way to ridges of generated scenes of the physical world, by all three channels: how much of it and
// its Angstrom exponent, beside the Cramer-Rao bound of one picture.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/estimator/landmarks/generated_landmarks.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

struct Day {
  AerosolKind kind;
  double aod_550, exponent;
  SunPlace sun;
  double cover = 0.0;
};
const std::vector<Day> kDays{
    {AerosolKind::continental, 0.05, 1.3, {50, 230}}, {AerosolKind::dust, 0.4, -0.1, {45, 80}},
    {AerosolKind::smoke, 0.3, 1.6, {58, 300}},        {AerosolKind::continental, 0.6, 1.3, {40, 200}, 1.0},
    {AerosolKind::maritime, 0.2, 0.1, {33, 170}},     {AerosolKind::urban, 0.8, 1.3, {62, 200}},
    {AerosolKind::polluted, 0.15, 1.5, {68, 30}},     {AerosolKind::desert, 0.8, 0.2, {50, 140}},
    {AerosolKind::continental, 0.1, 1.0, {65, 270}},  {AerosolKind::maritime, 0.1, 0.1, {50, 120}, 1.0},
    {AerosolKind::smoke, 0.6, 1.6, {35, 10}},         {AerosolKind::continental, 0.3, 1.3, {72, 190}}};
const std::vector<Day> kOtherDays{{AerosolKind::smoke, 0.15, 1.8, {30, 200}},
                                  {AerosolKind::polluted, 0.4, 1.4, {55, 100}},
                                  {AerosolKind::continental, 0.2, 0.7, {42, 330}},
                                  {AerosolKind::desert, 0.25, 0.4, {70, 215}},
                                  {AerosolKind::urban, 0.12, 1.5, {48, 160}},
                                  {AerosolKind::continental, 0.08, 1.6, {60, 20}},
                                  {AerosolKind::maritime, 0.35, 0.3, {66, 250}, 1.0},
                                  {AerosolKind::polluted, 0.08, 1.0, {37, 280}},
                                  {AerosolKind::smoke, 0.4, 1.2, {74, 110}},
                                  {AerosolKind::dust, 0.15, 0.1, {28, 190}},
                                  {AerosolKind::continental, 0.45, 1.0, {52, 60}, 1.0},
                                  {AerosolKind::urban, 0.3, 0.9, {64, 340}}};
const std::vector<Day> kDaysElsewhere{
    {AerosolKind::polluted, 0.25, 1.2, {40, 150}},    {AerosolKind::continental, 0.12, 1.4, {62, 260}},
    {AerosolKind::desert, 0.5, 0.3, {35, 240}},       {AerosolKind::smoke, 0.2, 1.7, {55, 350}},
    {AerosolKind::maritime, 0.15, 0.2, {45, 200}},    {AerosolKind::urban, 0.5, 1.4, {70, 130}},
    {AerosolKind::continental, 0.25, 1.1, {25, 180}}, {AerosolKind::polluted, 0.3, 1.6, {60, 40}, 1.0},
    {AerosolKind::dust, 0.25, 0.0, {58, 90}},         {AerosolKind::continental, 0.07, 1.2, {50, 310}},
    {AerosolKind::smoke, 0.5, 1.5, {45, 220}},        {AerosolKind::urban, 0.2, 1.3, {73, 230}}};

// One land, as it is seen towards a heading on those days.
struct Land {
  std::uint64_t terrain;
  double heading_deg;
  const std::vector<Day>* days;
};
const std::vector<Land> kTowardsNorth{{21, 4, &kDays}, {23, 4, &kDays}};
const std::vector<Land> kOnOtherDays{{22, 4, &kOtherDays}, {25, 4, &kOtherDays}};
const std::vector<Land> kElsewhere{
    {31, 140, &kDaysElsewhere}, {34, 275, &kDaysElsewhere}, {37, 140, &kDaysElsewhere}, {38, 275, &kDaysElsewhere}};

fixtures::Weather weather_of(const Day& day) {
  fixtures::Weather weather;
  weather.world = fixtures::World::physical;
  weather.aerosol = {day.aod_550, day.exponent, day.kind};
  weather.sun = direction_from(from_degrees(day.sun.zenith_deg), from_degrees(day.sun.azimuth_deg));
  weather.altitude_m = kValley_m;
  weather.cloud_cover = day.cover;
  return weather;
}

// Landmarks between 1 and 15 km, of which nothing is said, against the horizon as a configuration has them.
GeneratedView view_of_ridges(std::uint64_t terrain, double heading_deg = 4.0) {
  auto view = generated_view(terrain, heading_deg);
  std::erase_if(view.landmarks, [](const auto& one) { return one.distance_m < 1e3 || one.distance_m > 15e3; });
  for (auto& one : view.landmarks) one.infinity_sigma = infinity_sigma(one, view.camera.camera.width);
  return view;
}

struct Errors {
  double squares = 0.0, worst = 0.0, relative = 0.0;
  int count = 0;
  void add(double off, double sigma, double scale) {
    squares += off * off / (sigma * sigma);
    worst = std::max(worst, std::abs(off) / sigma);
    relative += std::abs(off) / scale;
    ++count;
  }
  double rms() const { return std::sqrt(squares / count); }
  double mean() const { return relative / count; }
};

void errors_are_as_sigma_says(const std::vector<Land>& lands, std::size_t quick_days) {
  const double column = kAerosolHeight_m * std::exp(kValley_m / kAerosolHeight_m);
  Errors amount, exponent;
  fmt::print("| aerosol | AOD | alone | bound | beside the others | exponent | alone | bound | beside the others |\n");
  for (const auto& land : lands) {
    if (&land != lands.data() && !whole_figures()) break;
    const auto view = view_of_ridges(land.terrain, land.heading_deg);
    ASSERT_GE(view.landmarks.size(), 4U);
    const LandmarkWatch watch(view.camera.camera, kValley_m, view.landmarks);
    std::vector<std::vector<ContrastReading>> pictures;
    std::uint64_t seed = 100 * land.terrain;
    auto days = *land.days;
    if (!whole_figures()) days.resize(quick_days);
    for (const auto& day : days)
      pictures.push_back(watch.read(view.camera.camera, encoded_in(view, weather_of(day), ++seed)));
    const auto airs = watch.estimate_all(pictures);
    for (std::size_t i = 0; i < days.size(); ++i) {
      const auto alone = watch.estimate(pictures[i]).aerosol;
      const auto& found = airs[i].aerosol;
      const auto bound = watch.colours().bound(pictures[i], days[i].aod_550 / column, days[i].exponent);
      fmt::print(
          "| {}{} | {:.2f} | {:.3f} +- {:.3f} | {:.3f} | {:.3f} +- {:.3f} | {:.1f} | {:.2f} +- {:.2f} | {:.2f} | "
          "{:.2f} "
          "+- {:.2f} |\n",
          name_of(days[i].kind), days[i].cover > 0.5 ? ", overcast" : "", days[i].aod_550, alone.per_m * column,
          std::sqrt(alone.covariance.per_m) * column, std::sqrt(bound.per_m) * column, found.per_m * column,
          std::sqrt(found.covariance.per_m) * column, days[i].exponent, alone.angstrom_exponent,
          std::sqrt(alone.covariance.exponent), std::sqrt(bound.exponent), found.angstrom_exponent,
          std::sqrt(found.covariance.exponent));
      for (const auto& one : {alone, found}) {
        amount.add(one.per_m * column - days[i].aod_550, std::sqrt(one.covariance.per_m) * column, days[i].aod_550);
        exponent.add(one.angstrom_exponent - days[i].exponent, std::sqrt(one.covariance.exponent), 1.0);
      }
    }
  }
  for (const auto& [errors, name] : {std::pair{amount, "amount"}, {exponent, "exponent"}}) {
    fmt::print("{}: errors over sigma rms {:.2f}, worst {:.2f}; mean error {:.3f}\n", name, errors.rms(), errors.worst,
               errors.mean());
    EXPECT_LT(errors.rms(), 1.5) << name;
    EXPECT_LT(errors.worst, 3.5) << name;
  }
}

TEST(AirTruthLandmarks, AmountAndExponentAreTheAirsWithinTheirSigma) {
  errors_are_as_sigma_says(kTowardsNorth, 4);
}

// Two other lands and twelve other days.
TEST(AirTruthLandmarks, OnOtherDaysTheyAreAsWell) {
  errors_are_as_sigma_says(kOnOtherDays, 2);
}

// Four lands, two headings and twelve days by which nothing was chosen.
TEST(AirTruthLandmarks, ElsewhereTheyAreAsWell) {
  errors_are_as_sigma_says(kElsewhere, 2);
}

// What the observer says of the channels holds what was found: the line through them is the aerosol, and an amount and
// an exponent that lie off along the covariance lie off as likely by channels.
TEST(AirTruthLandmarks, AReadingOfThePathHoldsWhatWasFound) {
  const auto view = view_of_ridges(21);
  const LandmarkColours colours(view.camera.camera, view.landmarks, kValley_m);
  PathAerosol found;
  found.kind = ExtinctionKind::value;
  found.per_m = 2e-4;
  found.angstrom_exponent = 1.1;
  found.covariance = {4e-10, 5e-7, 0.04};
  const auto reading = colours.reading_of(found);
  std::array<double, 3> x{}, aerosol{}, own{};
  double middle = 0.0, all = 0.0, both = 0.0, spread = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& channel = reading.channels[c];
    EXPECT_EQ(channel.kind, PathReading::Channel::Kind::value);
    x[c] = std::log(channel.wavelength_nm / 550.0);
    aerosol[c] = channel.per_m - rayleigh_per_m(ScatteringModel::aerosol, channel.wavelength_nm, kValley_m);
    EXPECT_NEAR(aerosol[c], found.per_m * std::exp(-found.angstrom_exponent * x[c]), 1e-9);
    own[c] = channel.sigma_per_m / aerosol[c];
    middle += x[c] / 3.0;
    all += channel.per_m;
    both += aerosol[c];
  }
  EXPECT_GT(reading.channels[0].wavelength_nm, reading.channels[1].wavelength_nm + 30.0);
  EXPECT_GT(reading.channels[1].wavelength_nm, reading.channels[2].wavelength_nm + 30.0);
  for (const double at : x) spread += (at - middle) * (at - middle);
  EXPECT_NEAR(own[1] / std::sqrt(spread), 0.2, 1e-6) << "sigma of the exponent";
  const double shared = reading.shared_sigma * all / both;
  const double expected = 0.01 - 2.0 * middle * 5e-7 / 2e-4 + middle * middle * 0.04;
  EXPECT_NEAR(shared * shared + own[1] * own[1] / 3.0, expected, 1e-6) << "variance in the channels' middle";
}

}  // namespace
}  // namespace kasumi
