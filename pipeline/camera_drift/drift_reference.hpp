// How the two cameras saw the world when they were calibrated: what later pictures are compared with.
#pragma once

#include <filesystem>

#include "calib/pose/view_edges.hpp"
#include "pipeline/camera_drift/drift_frames.hpp"

namespace kasumi {

// Small and still, so that nobody can be recognised in it: the median of pictures over minutes, at most 480 px long.
struct ViewReference {
  GreyPicture small;
  std::vector<ViewEdge> edges;  // of the full picture
};

struct DriftReference {
  Utc taken{};
  std::optional<ViewReference> scene, sky;
  std::optional<DomeFrame> dome;  // median, at most 160 px
  std::vector<Direction> suns;    // where the sun stood over it
  std::optional<double> turbidity;
  std::optional<double> level;                          // ln, see DriftFrames
  std::optional<Utc> scene_calibrated, sky_calibrated;  // of the calibrations it belongs to
};

// Errors (bad_input): fewer than 3 pictures of both cameras. Of one camera: then the other's alone.
Result<DriftReference> take_reference(const DriftFrames& frames, const Installation& installation, Utc now);
// Whether it was taken under these calibrations of these cameras; else one is to be taken anew.
bool belongs_to(const DriftReference& reference, const Installation& installation);

// STEM.check.json and STEM.check-scene.png, -sky.png, -dome.png.
Result<> save_reference(const DriftReference& reference, const std::filesystem::path& stem);
// Errors: io (there is none), bad_input (damaged, of another version).
Result<DriftReference> load_reference(const std::filesystem::path& stem);
// Beside the calibration file (else the file that names the cameras), under its name.
std::filesystem::path reference_stem(const Installation& installation, const std::filesystem::path& root_file);

}  // namespace kasumi
