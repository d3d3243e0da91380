// Real towers put back into their own pictures, the air told by the others. Without ../shared/data/real-air it is skipped.
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/statistics.hpp"
#include "base/utc_text.hpp"
#include "pipeline/lab/prove/proof_summary.hpp"
#include "pipeline/site/files/picture_times.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

struct MilanRow {
  std::string name, air_class;
  double sun_elevation_deg = 0.0;
  Utc utc{};
};

// name, sun_azimuth_deg, sun_elevation_deg, class, ...
std::vector<MilanRow> read_rows(const std::filesystem::path& table) {
  std::vector<MilanRow> rows;
  std::istringstream lines(read_text_file(table).value());
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream from(line);
    std::array<std::string, 4> cells;
    for (auto& cell : cells) std::getline(from, cell, ',');
    // Local time; summer time of 2025.
    const bool summer = cells[0] >= "20250330" && cells[0] < "20251026";
    const auto utc = picture_time(cells[0], {"%Y%m%d-%H%M", summer ? 2.0 : 1.0}).value();
    rows.push_back({cells[0], cells[3], std::stod(cells[2]), utc});
  }
  return rows;
}

struct ProvedTower {
  const char *name, *facade;
};
// The four that the goal is for, one that is five pixels wide, and one that is a mirror.
constexpr std::array kTowers{ProvedTower{"Galfa", "galfa"},          ProvedTower{"Lombardia", "lombardia-high"},
                             ProvedTower{"Solaria", "solaria-dark"}, ProvedTower{"Generali", "generali"},
                             ProvedTower{"Allianz", "allianz"},      ProvedTower{"UniCredit", "unicredit-left"}};
constexpr std::size_t kFour = 4;

std::string two(const ErrorSummary& errors) {
  return fmt::format("{}; {}", figure_text(errors.median_255, 1), figure_text(errors.p95_255, 0));
}

TEST(AirTruthProof, RealTowersAreDrawnAsTheCameraSawThem) {
  const auto folder = shared_data_folder() / "real-air/milan";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data: real-air/milan";
  const auto rows = read_rows(folder / "truth.csv");
  const auto list = test_folder("milan.list");
  std::string lines;
  std::map<std::string, double> elevations_deg;
  for (const auto& row : rows) {
    lines += fmt::format("{}\t{}\t{}\n", (folder / (row.name + ".jpg")).string(), utc_text(row.utc), row.air_class);
    elevations_deg[row.name] = row.sun_elevation_deg;
  }
  ASSERT_TRUE(write_text_file(list, lines));
  std::array<std::vector<double>, kProofWays.size()> four;
  std::vector<double> with_left_out;
  double within = 0.0;
  const auto towers = figure_cases("towers", std::vector<ProvedTower>{kTowers[3]}, {kTowers.begin(), kTowers.end()});
  for (std::size_t k = 0; k < towers.size(); ++k) {
    ProveRequest request;
    request.scenes = {"@" + list.string()};
    request.part = towers[k].facade;
    request.landmarks = (folder / "landmarks.toml").string();
    request.faces_deg = 26.0;  // to the camera
    request.lat = 45.5069;
    request.lon = 9.1997;
    const auto proof = prove(request);
    ASSERT_TRUE(proof) << proof.error().message;
    const auto summary = summary_of(*proof);
    for (const auto& picture : proof->pictures) {
      const auto& view = proof->scene.views[picture.view];
      EXPECT_NEAR(*picture.sun_elevation_deg, elevations_deg.at(view.file.stem().string()), 0.6) << view.file;
      if (k >= kFour || !picture.drawn) continue;
      with_left_out.push_back(picture.error_255(ProofWay::told));
      for (std::size_t way = 0; way < four.size() && picture.judged(); ++way)
        four[way].push_back(picture.error_255(kProofWays[way]));
    }
    if (k < kFour) within += summary.within_sigma_share / kFour;
    fmt::print("{}: {} of {} pictures; told {}, no air {}, T = 3 {}, best constant {}; bias {:+.1f} {:+.1f} {:+.1f}\n",
               towers[k].name, summary.ways[0].pictures, proof->pictures.size(), two(summary.ways[0]),
               two(summary.ways[1]), two(summary.ways[2]), two(summary.ways[3]), summary.bias_255.r, summary.bias_255.g,
               summary.bias_255.b);
    figure_row("real-proof", {towers[k].name, fmt::format("{:.2f}", proof->scene.part.distance_m / 1e3),
                              std::to_string(summary.ways[0].pictures), two(summary.ways[0]), "", two(summary.ways[1]),
                              two(summary.ways[2]), two(summary.ways[3]),
                              fmt::format("{:.0f} %", 100.0 * summary.within_sigma_share)});
  }
  if (towers.size() < kFour) return;
  const auto both = [&](ProofWay way) {
    const auto& errors = four[static_cast<std::size_t>(way)];
    return ErrorSummary{errors.size(), median(errors), quantile(errors, 0.95), 0.0};
  };
  const auto told = both(ProofWay::told), none = both(ProofWay::no_air);
  fmt::print("four towers: told {}, no air {}, T = 3 {}, best constant {}; within sigma {:.0f} %\n", two(told),
             two(none), two(both(ProofWay::fixed_t)), two(both(ProofWay::constant)), 100.0 * within);
  figure_row("real-proof",
             {"the first four", "", std::to_string(told.pictures), two(told), "<= 4.0; <= 24", two(none),
              two(both(ProofWay::fixed_t)), two(both(ProofWay::constant)), fmt::format("{:.0f} %", 100.0 * within)});
  const ErrorSummary all{with_left_out.size(), median(with_left_out), quantile(with_left_out, 0.95), 0.0};
  figure_row("real-proof",
             {"the first four, with those left out", "", std::to_string(all.pictures), two(all), "", "", "", "", ""});
  EXPECT_LT(told.median_255, 0.5 * none.median_255);
}

}  // namespace
}  // namespace kasumi
