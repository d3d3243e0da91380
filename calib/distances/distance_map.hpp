// Distance of the real scene in each pixel of a camera's picture: the one reader of files of distances.
// What a number means (docs/photographs.md#distances):
//   > 0, at most sky_beyond_m       metres along the pixel's line of sight
//   inf, more than sky_beyond_m     sky; so is 65504 among floats, the largest of half floats
//   0                               sky where that is said (retarget, depth_map), else nothing is known (haze)
//   NaN, no_data                    nothing is known; so is 65535 in a file of 16 bits
//   < 0, but no_data                an error
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/image.hpp"
#include "base/result.hpp"
#include "base/table/config_table.hpp"

namespace kasumi {

constexpr double kSkyBeyond_m = 167e3;  // what the renderer's depth can hold

// How the numbers v of a file are meant.
struct DistanceFile {
  enum class Holds {
    metres,     // scale v; integers need a scale, floats have 1
    disparity,  // scale / (v + offset), scale in pixels times metres; 0 and inf are not known, as stereo leaves them
    inverse     // 1 / (scale v + offset), as networks give; at most 0 is sky
  };
  Holds holds = Holds::metres;
  std::optional<double> scale;
  double offset = 0.0;
  std::optional<double> no_data;  // this v
  bool zero_is_sky = false;       // but in sparse files
  double sky_beyond_m = kSkyBeyond_m;
  std::string channel;  // of an EXR; empty: Z, *.Z, V, Y, or R of grey
};

struct DistanceMap {
  Image<float> metres;  // 0: nothing is known; infinity: sky
  double near_m = 0.0, far_m = 0.0;
  double known = 0.0, sky = 0.0;     // shares of the picture
  std::vector<std::string> remarks;  // "resampled from 256 x 192 to 1024 x 768"
  // "2.00 to 60.0 m in 58.1 % of the picture, sky in 0.0 %, nothing known in 41.9 %; resampled from ..."
  std::string summary() const;
};

// A grey PNG or TIFF of 16 bits, a PFM (whose header's scale is the order of its bytes), a TIFF or EXR of floats. One
// of another size but the same shape (2 %) is resampled. A sparse one, a lidar's, is filled between its pixels, never
// above the topmost. Errors (bad_input): the file, a channel, nothing known anywhere, all within a metre with no unit
// given; unsupported.
Result<DistanceMap> read_distances(const std::filesystem::path& path, const DistanceFile& file, int width, int height);

// Metres, 0 where there is sky. A region of which nothing is known is sky from that share of the picture on; a smaller
// one has the distance of the nearest that is known.
Image<float> sky_as_zero(const DistanceMap& map, double smallest_sky_share = 0.02);

// depth_map and depth_* of [scene]. `metres` empty without the key. 0 in the file is sky. Problems are recorded in the
// table. `summary`: what the map knows, for people.
Image<float> read_distance_map(const ConfigTable& scene, int width, int height, std::string* summary = nullptr);

}  // namespace kasumi
