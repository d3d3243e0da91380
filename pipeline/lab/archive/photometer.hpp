// What a sun photometer measured beside the camera: AERONET's tables of aerosol optical depth, version 3.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct PhotometerReading {
  Utc utc;
  double aod_550 = 0.0;
};

// ln of depth over ln of wavelength at 550 nm: a parabola through all channels from 400 to 900 nm by least squares
// (Eck 1999), or Angstrom's line through two. Empty: fewer, or none on each side of 550 nm.
struct ChannelDepth {
  double wavelength_nm = 0.0, aod = 0.0;
};
std::optional<double> aod_at_550(const std::vector<ChannelDepth>& channels);

// Files .lev10, .lev15 or .lev20 as aeronet.gsfc.nasa.gov gives them, ordered by time. Rows without usable channels are
// left out. Errors (bad_input): the file, what is wrong with it and in which line.
Result<std::vector<PhotometerReading>> read_photometer(const std::vector<std::filesystem::path>& files);

// The camera against the photometer.
struct PhotometerAgreement {
  std::size_t pairs = 0;
  double bias = 0.0, rmse = 0.0;  // camera - photometer
  double scatter = 0.0;           // standard deviation of the differences; 95 % are within bias +- 1.96 of it
  double within_expected = 0.0;   // share within +- (0.05 + 0.15 of the photometer's), as of satellites over land
};

class PhotometerComparison {
 public:
  struct Pair {
    float camera, photometer;
  };
  explicit PhotometerComparison(std::vector<PhotometerReading> readings) : readings_(std::move(readings)) {}
  // A record whose air is known, with a reading within 15 minutes: the nearest.
  void add(const nlohmann::json& record);
  const std::vector<Pair>& pairs() const { return pairs_; }
  std::size_t readings() const { return readings_.size(); }
  PhotometerAgreement agreement() const;

 private:
  std::vector<PhotometerReading> readings_;
  std::vector<Pair> pairs_;
};

}  // namespace kasumi
