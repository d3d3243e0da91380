// A sky scanner's table in place of a picture: what is read of it, what is refused, and what the real command answers.
#include "base/outside/json_text.hpp"
#include "pipeline/lab/photographs/scan_readings.hpp"

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "pipeline/site/files/csv_table.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kSun = "--sun-zenith-deg 40 --sun-azimuth-deg 130 ";

std::filesystem::path written(const std::string& name, const std::string& text) {
  const auto file = test_folder("scans") / (name + ".csv");
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text;
  return file;
}

// A line for each of 145 directions, as scanners take them: rings 12 deg apart.
struct Line {
  double azimuth_deg = 0.0, elevation_deg = 0.0;
  Direction direction() const { return direction_from(from_degrees(90.0 - elevation_deg), from_degrees(azimuth_deg)); }
};
std::vector<Line> lines_of_a_scanner() {
  std::vector<Line> lines;
  for (const auto& [elevation, steps] :
       {std::pair{6.0, 30}, {18.0, 30}, {30.0, 24}, {42.0, 24}, {54.0, 18}, {66.0, 12}, {78.0, 6}, {90.0, 1}})
    for (int i = 0; i < steps; ++i) lines.push_back({360.0 * i / steps, elevation});
  return lines;
}

TEST(SkyScanTable, SemicolonsAndDecimalCommasAreReadAsSpreadsheetsWriteThem) {
  Problems problems;
  const auto comma = CsvTable::read(written("comma", "azimuth_deg,luminance\n6,670.6\n42,1.5e3\n"), problems);
  const auto semicolon = CsvTable::read(written("semicolon", "azimuth_deg;luminance\n6;670,6\n42;1,5e3\n"), problems);
  const auto tab = CsvTable::read(written("tab", "azimuth_deg\tluminance\n6\t670.6\n42\t1,5e3\n"), problems);
  ASSERT_TRUE(problems.empty());
  for (const auto& table : {semicolon, tab})
    for (std::size_t row = 0; row < 2; ++row)
      for (std::size_t column = 0; column < 2; ++column)
        EXPECT_EQ(table.number(row, column, 0, 1e4, problems), comma.number(row, column, 0, 1e4, problems));
  EXPECT_TRUE(problems.empty());
  const auto thousands = CsvTable::read(written("thousands", "a;b\n1;1,234,567\n"), problems);
  EXPECT_FALSE(thousands.number(0, 1, 0, 1e9, problems)) << "no thousands: two commas are no number";
}

// The dome's own sky as X, Y, Z, or whatever `change` makes of it.
std::string table_of_dome(const Aerosol& aerosol, const std::function<glm::dvec3(int, glm::dvec3)>& change = {}) {
  const auto sky = dome(0.0, aerosol, direction_from(from_degrees(40.0), from_degrees(130.0)));
  std::string text = "azimuth_deg,elevation_deg,X,Y,Z\n";
  int number = 0;
  for (const auto& line : lines_of_a_scanner()) {
    glm::dvec3 xyz = dome_light(sky, line.direction());
    if (change) xyz = change(number, xyz);
    text += fmt::format("{},{},{:.6g},{:.6g},{:.6g}\n", line.azimuth_deg, line.elevation_deg, xyz.x, xyz.y, xyz.z);
    ++number;
  }
  return text;
}

nlohmann::json answer_to(const std::string& options, const std::filesystem::path& file) {
  const auto outcome = run_kasumi("estimate --json " + options + " --scan " + file.string());
  if (outcome.code > 1) {
    ADD_FAILURE() << outcome.err;
    return {};
  }
  const auto json = parse_json(outcome.out);
  EXPECT_EQ(outcome.code, json["usable"] ? 0 : 1) << outcome.err;
  return json;
}

TEST(SkyScanTable, XyzLuminanceAndSpectraAreRead) {
  std::string xyz = "azimuth_deg,elevation_deg,X,Y,Z\n", luminance = "elevation_deg, luminance ,azimuth_deg\r\n",
              spectra = "azimuth_deg,elevation_deg";
  for (int nm = 380; nm <= 780; nm += 10) spectra += fmt::format(",L{}", nm);
  spectra += "\n";
  for (int i = 0; i < 24; ++i) {
    xyz += fmt::format("{},30,95.047,100,108.883\n", 15 * i);
    luminance += fmt::format("30,{},{}\r\n\r\n", 1000 + i, 15 * i);
    spectra += fmt::format("{},30", 15 * i);
    for (int nm = 380; nm <= 780; nm += 10) spectra += fmt::format(",{}", daylight_spectrum(0.3127, 0.3290, nm));
    spectra += "\n";
  }
  const auto of_xyz = must(read_scan_readings(written("xyz", xyz)));
  ASSERT_EQ(of_xyz->readings.size(), 24u);
  EXPECT_TRUE(of_xyz->colours);
  EXPECT_NEAR(of_xyz->readings[0].light.r / of_xyz->readings[0].light.b, 1.0, 1e-3) << "D65 is white";
  EXPECT_NEAR(to_degrees(azimuth_angle(of_xyz->readings[7].direction)), 105.0, 1e-9);
  EXPECT_NEAR(to_degrees(zenith_angle(of_xyz->readings[7].direction)), 60.0, 1e-9);

  const auto of_luminance = must(read_scan_readings(written("luminance", luminance)));
  EXPECT_FALSE(of_luminance->colours);
  EXPECT_NEAR(of_luminance->readings[3].light.g, 1003.0, 1e-6);
  EXPECT_NEAR(of_luminance->readings[3].light.r, of_luminance->readings[3].light.b, 1e-6);

  const auto of_spectra = must(read_scan_readings(written("spectra", spectra)));
  EXPECT_TRUE(of_spectra->note.empty());
  const auto white = of_spectra->readings[0].light;
  EXPECT_NEAR(white.r / white.g, 1.0, 0.01);
  EXPECT_NEAR(white.b / white.g, 1.0, 0.01);
}

// A spectrum's colour is that of its shape, however its wavelengths are chosen.
TEST(SkyScanTable, UnevenWavelengthsGiveTheSameColour) {
  const auto table = [](const std::vector<double>& wavelengths) {
    std::string text = "azimuth_deg,elevation_deg";
    for (const double nm : wavelengths) text += fmt::format(",L{}", nm);
    text += "\n";
    for (int i = 0; i < 24; ++i) {
      text += fmt::format("{},45", 15 * i);
      for (const double nm : wavelengths) text += fmt::format(",{}", 0.3 - 3e-4 * (nm - 380.0));
      text += "\n";
    }
    return text;
  };
  const auto even = read_scan_readings(written("even", table({380, 420, 460, 500, 540, 580, 620, 660, 700, 740, 780})));
  const auto uneven = read_scan_readings(
      written("uneven", table({370, 395.5, 400, 431, 470, 510, 520, 559, 590, 612, 650, 690, 720, 760, 800})));
  ASSERT_TRUE(even) << even.error().message;
  ASSERT_TRUE(uneven) << uneven.error().message;
  for (const int i : {0, 1, 2}) EXPECT_NEAR(uneven->readings[5].light[i] / even->readings[5].light[i], 1.0, 1e-6) << i;
}

TEST(SkyScanTable, ColumnsThatAreNotUsedAreTold) {
  std::string text = "azimuth_deg,elevation_deg,luminance,temperature,shutter\n";
  for (int i = 0; i < 24; ++i) text += fmt::format("{},30,1000,dew,open\n", 15 * i);
  const auto file = written("more", text);
  const auto scan = must(read_scan_readings(file));
  EXPECT_EQ(scan->note, "not used: columns temperature, shutter");
  const auto outcome = run_kasumi(fmt::format("estimate --json {} --scan {}", kSun, file.string()));
  EXPECT_LE(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("more.csv: not used: columns temperature, shutter"));
}

struct Damage {
  const char* name;
  const char* from;  // in the table ...
  const char* to;    // ... becomes this
  const char* told;  // after the file's name
};

class DamagedScan : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedScan, IsRefusedWithLineAndColumn) {
  std::string text = "azimuth_deg,elevation_deg,X,Y,Z\n";
  for (int i = 0; i < 24; ++i) text += fmt::format("{},30,10{},20{},30{}\n", 15 * i, i, i, i);
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const auto file = written(GetParam().name, text);
  const auto outcome = ended(2, run_kasumi(fmt::format("estimate --json {} --scan {}", kSun, file.string())));
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr(file.string() + GetParam().told));
}

INSTANTIATE_TEST_SUITE_P(
    Tables, DamagedScan,
    ::testing::Values(
        Damage{"no_azimuth", "azimuth_deg", "azimut", ":1: column azimuth_deg is missing"},
        Damage{"no_elevation", "elevation_deg", "height", ":1: column elevation_deg is missing"},
        Damage{"no_light", "X,Y,Z", "a,b,c", ":1: no light: expected columns L380 ... L780"},
        Damage{"no_z", "X,Y,Z", "X,Y,W", ":1: column Z is missing"},
        Damage{"twice", "X,Y,Z", "X,X,Z", ":1: column 4 is 'X' again, as column 3 is"},
        Damage{"nameless", "X,Y,Z", "X,,Z", ":1: column 4 has no name"},
        Damage{"text", "1010", "bright", ":12: column 3 (X): 'bright': expected a number"},
        Damage{"half", "1010", "10e", ":12: column 3 (X): '10e': expected a number"},
        Damage{"nan", "1010", "nan", ":12: column 3 (X): 'nan'"},
        Damage{"infinite", "1010", "inf", ":12: column 3 (X): 'inf'"},
        Damage{"negative", "1010", "-1010", ":12: column 3 (X): '-1010': expected a number from 0 to 1e+15"},
        Damage{"overflow", "1010", "1.7e308", ":12: column 3 (X): '1.7e308': expected a number from 0 to 1e+15"},
        Damage{"empty", "1010", "", ":12: column 3 (X): ''"},
        Damage{"below", "45,30", "45,-3", ":5: column 2 (elevation_deg): '-3': expected a number from 0 to 90"},
        Damage{"above", "45,30", "45,93", ":5: column 2 (elevation_deg): '93'"},
        Damage{"turned", "45,30", "450,30", ":5: column 1 (azimuth_deg): '450': expected a number from -360 to 360"},
        Damage{"short", "1010,", "", ":12: 4 cells, the last in column 4: expected 5"},
        Damage{"long", "1010,", "1010,7,", ":12: 6 cells, the last in column 6: expected 5"},
        Damage{"dark", "1010,2010,3010", "0,0,0", ":12: no light of a sky"}),
    [](const auto& damaged) { return damaged.param.name; });

TEST(SkyScanTable, EveryProblemIsToldAtOnce) {
  std::string text = "azimuth_deg,elevation_deg,X,Y,Z\n0,95,1,1,x\n10,20\n20,30,-1,1,1\n";
  const auto outcome = ended(2, run_kasumi(fmt::format("estimate {} --scan {}", kSun, written("all", text).string())));
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("all.csv:2: column 2 (elevation_deg): '95'"),
                                          HasSubstr("all.csv:2: column 5 (Z): 'x'"), HasSubstr("all.csv:3: 2 cells"),
                                          HasSubstr("all.csv:4: column 3 (X): '-1'")));
}

TEST(SkyScanTable, TooLittleIsRefused) {
  const auto told = [](const std::string& name, const std::string& text) {
    const auto outcome = run_kasumi(fmt::format("estimate {} --scan {}", kSun, written(name, text).string()));
    EXPECT_EQ(outcome.code, 2) << name;
    return outcome.err;
  };
  EXPECT_THAT(told("nothing", ""), HasSubstr("nothing.csv: is empty"));
  EXPECT_THAT(told("names", "azimuth_deg,elevation_deg,luminance\n"),
              HasSubstr("names.csv: 0 directions: expected at least 20"));
  EXPECT_THAT(told("narrow", "azimuth_deg,elevation_deg,L500,L510\n0,10,1,1\n"),
              HasSubstr("narrow.csv:1: the wavelengths go from 500 to 510 nm: expected at least from 440 to 660"));
  EXPECT_THAT(told("gap", "azimuth_deg,elevation_deg,L400,L430,L600,L630,L660,L700\n0,10,1,1,1,1,1,1\n"),
              HasSubstr("gap.csv:1: no wavelength between 430 and 600 nm"));
  EXPECT_THAT(told("again", "azimuth_deg,elevation_deg,L400,L440,L440.0,L480\n0,10,1,1,1,1\n"),
              HasSubstr("again.csv:1: column 5 is 440 nm again, as column 4 is"));
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("estimate {} --scan /nowhere/scan.csv", kSun))).err,
              HasSubstr("/nowhere/scan.csv: cannot be read"));
}

TEST(SkyScanTable, AMillionProblemsAreNotAllTold) {
  std::string text = "azimuth_deg,elevation_deg,luminance\n";
  for (int i = 0; i < 500; ++i) text += "x,y,z\n";
  const auto scan = read_scan_readings(written("garbage", text));
  ASSERT_FALSE(scan);
  EXPECT_THAT(scan.error().message, testing::AllOf(HasSubstr("... and 1460 more"), Not(HasSubstr("garbage.csv:60:"))));
}

TEST(SkyScanTable, TheLargestValuesGiveFiniteLight) {
  std::string text = "azimuth_deg,elevation_deg,X,Y,Z\n";
  for (int i = 0; i < 24; ++i) text += fmt::format("{},30,1e15,1e15,1e15\n", 15 * i);
  const auto scan = must(read_scan_readings(written("largest", text)));
  for (const auto& reading : scan->readings)
    for (const int i : {0, 1, 2}) EXPECT_TRUE(std::isfinite(reading.light[i]));
}

TEST(SkyScanTable, AWavelengthIsAFiniteNumber) {
  std::string text = "azimuth_deg,elevation_deg,luminance,Lnan,Linf,L-inf,L1e999\n";
  for (int i = 0; i < 24; ++i) text += fmt::format("{},30,1000,1,1,1,1\n", 15 * i);
  const auto scan = must(read_scan_readings(written("wavelengths", text)));
  EXPECT_EQ(scan->note, "not used: columns Lnan, Linf, L-inf, L1e999");
}

// Each name is looked up, not compared with all before it: a table of 200,000 columns took two minutes.
TEST(SkyScanTable, ManyColumnsAreReadInTheTimeTheyTake) {
  std::string text = "azimuth_deg,elevation_deg,luminance";
  for (int i = 0; i < 200000; ++i) text += fmt::format(",c{}", i);
  text += ",c7\n";
  Problems problems;
  const auto file = written("columns", text);
  const auto began = std::chrono::steady_clock::now();
  const auto table = CsvTable::read(file, problems);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(10));
  EXPECT_EQ(table.names().size(), 200004u);
  EXPECT_THAT(problems.fault().message, HasSubstr("columns.csv:1: column 200004 is 'c7' again, as column 11 is"));
}

// Whatever becomes of a table, it is read or refused with a reason.
TEST(SkyScanTable, AnyDamageIsReadOrRefused) {
  std::string whole = "azimuth_deg,elevation_deg,L400,L500,L600,L700\n";
  for (int i = 0; i < 24; ++i) whole += fmt::format("{},30,.1{},.2,.15,.1\n", 15 * i, i);
  std::mt19937 random(7);
  const auto any = [&](std::size_t below) { return std::uniform_int_distribution<std::size_t>(0, below - 1)(random); };
  int refused = 0;
  for (int turn = 0; turn < 1000; ++turn) {
    std::string text = whole;
    for (std::size_t change = 0; change <= any(4) && !text.empty(); ++change) {
      const auto at = any(text.size());
      switch (any(4)) {
        case 0: text[at] = static_cast<char>(any(256)); break;
        case 1: text.erase(at, 1 + any(20)); break;
        case 2: text.insert(at, std::string(1 + any(3), ",-.e\n\r\"L0"[any(9)])); break;
        default: text.resize(at + 1); break;
      }
    }
    const auto scan = read_scan_readings(written("any", text));
    if (scan) {
      EXPECT_GE(scan->readings.size(), 20u);
      continue;
    }
    ++refused;
    EXPECT_EQ(scan.error().kind, FaultKind::bad_input);
    EXPECT_THAT(scan.error().message, HasSubstr("any.csv"));
  }
  EXPECT_GT(refused, 500);
}

TEST(ScanCommand, WrongOptionsAreToldAtOnce) {
  const auto file = written("options", table_of_dome({0.1})).string();
  const auto outcome =
      run_kasumi("estimate --sun-from-image --method reference-pixel --plot picture.png --scan " + file);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("--scan: stands instead of pictures"),
                                          HasSubstr("--sun-from-image: a scan is no picture"),
                                          HasSubstr("--method reference-pixel"), HasSubstr("--plot")));
  EXPECT_THAT(ended(2, run_kasumi("estimate --scan " + file)).err, HasSubstr("the sun's position is unknown"));
}

TEST(ScanCommand, TheOthersAreAnsweredWhenOneTableIsDamaged) {
  const auto good = written("good", table_of_dome({0.1})), bad = written("bad", "azimuth_deg\n");
  const auto outcome =
      run_kasumi(fmt::format("estimate --json {} --scan {} --scan {}", kSun, bad.string(), good.string()));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("bad.csv:1: column elevation_deg is missing"));
  EXPECT_EQ(parse_json(outcome.out)["image"], good.string());
}

TEST(ScanCommand, TheSunFollowsFromTimeAndPlace) {
  const auto file = written("place", table_of_dome({0.1}));
  const auto json = answer_to("--lat 42.443449 --lon -76.481962 --altitude-m 270 --utc 2013-05-27T14:01:00Z", file);
  EXPECT_NEAR(json["sun_zenith_deg"].get<double>(), 43.33, 0.05);
  EXPECT_NEAR(json["sun_azimuth_deg"].get<double>(), 104.44, 0.05);
  const auto night = answer_to("--lat 42.443449 --lon -76.481962 --utc 2013-05-27T04:01:00Z", file);
  EXPECT_FALSE(night["usable"]);
  EXPECT_EQ(night["sky"], "night");
}

TEST(ScanCommand, JsonHasEveryKeyOfAPicturesAnswer) {
  const auto json = answer_to(kSun, written("keys", table_of_dome({0.1})));
  for (const char* key : {"image",          "turbidity",      "sigma",
                          "usable",         "reason",         "sky",
                          "clear_fraction", "samples",        "log_residual",
                          "sky_model",      "sun_zenith_deg", "sun_azimuth_deg",
                          "aod_550",        "sigma_aod_550",  "angstrom_exponent",
                          "sigma_angstrom", "aerosol",        "models",
                          "visibility_m",   "weather"})
    EXPECT_TRUE(json.contains(key)) << key;
}

}  // namespace
}  // namespace kasumi
