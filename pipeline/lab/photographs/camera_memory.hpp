// Properties of a camera that need several of its pictures: its image circle, its tone curve, how it was turned, and
// whether it mirrors. From all pictures of a call, and from calls before it where a file keeps them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "calib/mask/fixed_circle.hpp"
#include "calib/pose/azimuth_fit.hpp"
#include "estimator/sky_fit/camera_belief.hpp"

namespace kasumi {

struct RememberedCamera {
  int width = 0, height = 0;  // of its pictures
  FoundCircle circle;         // as find_image_circle gives it
  int pictures = 0;           // that see this circle
  CameraBelief belief;
  int tones = 0;  // pictures that determined its tone exponent
  std::optional<AzimuthFit> turn;
  std::vector<SunPair> suns;  // the latest, which the turn rests on

  // Tones of this call by picture, and the belief that they were asked under.
  std::map<std::filesystem::path, ToneSight> told;
  CameraBelief before;
};

// What one picture says of its camera.
struct CameraSight {
  std::filesystem::path file;
  SizedCircle circle;  // with the circle that was used
  std::optional<ToneSight> tone;
  std::optional<SunPair> sun;  // where it is seen, and where time and place put it
};

class CameraMemory {
 public:
  // A file that is not there is an empty memory. Errors (bad_input): no such memory, each wrong key.
  static Result<CameraMemory> read(const std::filesystem::path& file);
  Result<> write(const std::filesystem::path& file) const;

  // Cameras that these pictures show, and those known before. What was found is kept for found_in().
  void learn_circles(const std::map<std::filesystem::path, SizedCircle>& pictures);
  // Tone curves and turns. The suns of `pictures` were seen by cameras of without_turns().
  void learn(const std::vector<CameraSight>& pictures);
  CameraMemory without_turns() const;

  // The circle of a picture in which `found` was found alone.
  std::optional<FoundCircle> circle_of(const SizedCircle& alone) const;
  // Found in a file before, to spare the search.
  const SizedCircle* found_in(const std::filesystem::path& file) const;
  // Null: no camera with this circle is known by several pictures; a single picture adds nothing to itself.
  const RememberedCamera* camera_of(int width, int height, const ImageCircle& circle) const;
  // Whether any picture showed such a camera.
  bool knows(int width, int height, const ImageCircle& circle) const;
  // The prior of a camera for this picture: without the picture's own contribution.
  static CameraBelief belief_beside(const RememberedCamera& camera, const std::filesystem::path& file);
  const std::vector<RememberedCamera>& cameras() const { return cameras_; }

 private:
  std::vector<RememberedCamera> cameras_;
  std::map<std::filesystem::path, SizedCircle> found_;
};

}  // namespace kasumi
