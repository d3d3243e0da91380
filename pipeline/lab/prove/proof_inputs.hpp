// The pictures of the scene camera, brought onto one view, and what is kept of each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"
#include "estimator/photograph/facade.hpp"
#include "pipeline/lab/prove/prove_request.hpp"

namespace kasumi {

struct ProofView {
  std::filesystem::path file;
  std::optional<Utc> utc;
  std::string label;                      // of a list, empty: none
  std::string unusable;                   // why it is excluded before its air is estimated: night, another size
  bool placed = false;                    // its lines were found; false: taken to stand as its neighbour does
  double moved_px = 0.0;                  // of the part, in that picture
  double blurred_share = 0.0;             // of the picture, by drops on the lens
  std::vector<ContrastReading> readings;  // of the others
  FacadeBackdrop sky;
  bool sky_clipped = false;
  Image<Rgb8> patch;  // the part and what is around it, as seen
};

struct ProofInputs {
  Camera camera;
  double altitude_m = 0.0;
  std::optional<Site> site;
  ContrastLandmark part;
  std::vector<ContrastLandmark> others;  // none of the part's own building
  std::vector<std::string> left_aside;   // names of landmarks of the part's own building
  LandmarkBox patch;                     // in the reference's pixels
  std::filesystem::path reference;
  std::vector<ProofView> views;  // in order of time
  int unreadable = 0;

  // The part's pixels of a view, as the camera gave them.
  Image<glm::vec3> part_of(const ProofView& view) const;
  // The same as light.
  Image<glm::vec3> light_of_part(const Image<glm::vec3>& encoded) const;
};

// Errors (bad_input): all of the request and of the landmarks' file; no picture; no two of one view.
Result<ProofInputs> read_proof_inputs(const ProveRequest& request);

}  // namespace kasumi
