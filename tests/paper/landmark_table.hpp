// KNMI's meadow at De Bilt: visibility from the contrast of landmarks, compared with the measured one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct LandmarkRow {
  std::string frame;             // file name
  double measured_m = 0.0;       // MOR at the station's sensor
  double optical_range_m = 0.0;  // ours, MOR: the value, or the bound
  double sigma_m = 0.0;          // of a value
  std::string kind;              // "value"; "visibility at least", "visibility at most" this
  double colours_m = 0.0;        // the same by all channels at once
  double colours_sigma_m = 0.0;
  double bound = 0.0;       // Cramer-Rao: relative sigma that such readings can reach in air of the measured range
  double tower = 0.0;       // contrast of the first landmark, as read
  bool within_1_5 = false;  // a value within a factor 1.5 of the measured; a bound that the measured keeps
};

struct RefusedFrame {
  std::string frame, reason;
};

struct LandmarkTable {
  std::vector<LandmarkRow> rows;      // daylight colour frames, by measured visibility
  std::vector<RefusedFrame> refused;  // by night, in infrared light
  double best_spearman = 0.0;         // with every value at its own rank and the bounds sharing theirs
  double spearman = 0.0;              // of ours and measured; equal bounds ("at least", "at most") share a rank
};

// The frames of shared/data/haze/knmi-debilt; `landmarks`: tests/paper/knmi-debilt.toml. Errors: bad_input.
Result<LandmarkTable> landmark_table(const std::filesystem::path& folder, const std::filesystem::path& landmarks);
// Spearman's rank correlation, ties share their mean rank.
double spearman(const std::vector<double>& one, const std::vector<double>& other);

}  // namespace kasumi
