// The arguments of `kasumi estimate`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/air_options.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"
#include "pipeline/site/files/picture_times.hpp"

namespace CLI {
class App;
}

namespace kasumi {

struct EstimateRequest {
  std::vector<std::string> images;  // of the sky: files, folders, recordings, "@LIST", patterns, "-"; in order
  std::vector<std::string> lists;   // until they are in `images`
  std::vector<std::string> scenes;  // of the scene camera
  std::vector<std::string> scans;   // a sky scanner's tables, instead of pictures
  std::string landmarks;
  std::string measured;            // visibilities beside --scene
  std::vector<std::string> hazes;  // photographs of land whose haze is estimated
  std::vector<int> part;           // of them: left, top, width, height
  std::optional<double> distance_m;
  std::string calibration;
  std::vector<std::string> cameras;  // FROM..TO=FILE: calibrations, each of a time
  std::string lens = "equidistant";
  std::optional<double> fov_deg;
  std::vector<double> circle;
  std::optional<double> azimuth_up_deg;
  std::string response;  // empty: auto where every model of the sky is fitted, else srgb
  std::optional<double> tone_exponent;
  std::string vignetting = "fit";  // or the share of light that is lost at the rim
  std::string camera_memory;
  std::optional<double> sun_zenith_deg, sun_azimuth_deg, lat, lon;
  std::optional<double> altitude_m;  // empty: not given; taken as sea level, within some 500 m
  std::string utc;
  bool sun_from_image = false;
  bool allow_damaged = false;
  std::string method = "free-gain";
  std::string sky_model;  // empty: auto, or preetham with the papers' method
  AirOptions aerosol;     // exponent and kind
  int samples = EstimateParameters{}.samples;
  std::uint64_t seed = 1;
  bool json = false;
  bool csv = false;
  bool plot = false;
  std::string plot_dir;
  std::size_t jobs = 0;

  std::string time_format;  // empty: pictures have times by lists, recordings and --utc alone; "auto": as names usually
  double utc_offset_h = 0.0;
  std::string out;    // of an archive's part, or of a merge
  std::string shard;  // empty: as the job array says
  bool resume = false;
  std::string learn_camera;
  std::vector<std::string> merge;
  std::string summary;  // empty: summary.html beside `out`
  std::vector<std::string> photometers;
  std::string given_words;  // options as given that answers depend on, one a line; after parsing

  bool response_from_pictures() const { return response == "estimate"; }
};

void add_estimate_options(CLI::App& command, EstimateRequest& arguments);
// Puts each --list into the images, as @LIST or -, where it stood among them. After parsing.
void order_lists(const CLI::App& command, EstimateRequest& arguments);

// Of options whose value changes an answer, and with what they were given.
std::string words_of_answers(const CLI::App& command);

// How to read the pictures of the sky. Errors (bad_input): everything that is wrong with them at once.
Result<PhotographSetup> photograph_setup(const EstimateRequest& arguments);

}  // namespace kasumi
