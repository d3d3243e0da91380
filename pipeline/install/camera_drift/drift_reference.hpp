// How the two cameras saw the world at calibration time, with which later pictures are compared. No pictures: lines.
#pragma once

#include <filesystem>

#include "calib/pose/view_edges.hpp"
#include "pipeline/install/camera_drift/drift_frames.hpp"

namespace kasumi {

// Of the median of pictures over minutes, free of people and vehicles.
struct ViewReference {
  ViewLines lines;  // at most 480 px long
  DarkPlaces darkest;
  std::vector<ViewEdge> edges;  // of the full-size picture
};

struct DriftReference {
  Utc taken{};
  std::optional<ViewReference> scene, sky;
  std::optional<DomeShade> dome;  // of the median, at most 160 px
  std::vector<Direction> suns;    // the sun's positions in those pictures
  std::optional<double> turbidity;
  std::optional<double> level;                          // ln, see DriftFrames
  std::optional<Utc> scene_calibrated, sky_calibrated;  // of the calibrations it belongs to
};

// A camera with fewer than 3 pictures is left out. Errors (bad_input): so few of both.
Result<DriftReference> take_reference(const DriftFrames& frames, const Installation& installation, Utc now);
// Whether it was taken with the present calibrations; otherwise a new reference is needed.
bool belongs_to(const DriftReference& reference, const Installation& installation);

// STEM.check.json. Removes the pictures that earlier versions left next to it.
Result<> save_reference(const DriftReference& reference, const std::filesystem::path& stem);
// Errors: io (there is none), bad_input (damaged, of another version).
Result<DriftReference> load_reference(const std::filesystem::path& stem, const Installation& installation);
// Earlier versions kept pictures, from which the reference is then made: save it to be rid of them. What cannot be read
// is only removed. Nothing happens if there are none.
Result<> replace_kept_pictures(const std::filesystem::path& stem, const Installation& installation);
// Next to the calibration file (without one, the file that describes the cameras), with its name.
std::filesystem::path reference_stem(const Installation& installation, const std::filesystem::path& root_file);

}  // namespace kasumi
