// Looks at the real ground around the object, where its shadow may fall: how much of the sun's light reaches it, and how
// much of the sky the object hides from it. Takes longer than a picture lasts, so it is done apart; by one thread at a
// time.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"
#include "capture/frame.hpp"
#include "estimator/ground/ground_memory.hpp"
#include "gles/scene.hpp"
#include "pipeline/show/scene/foot_shade.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

struct GroundLook {
  std::shared_ptr<const GroundSunlight> sunlight;  // null: not seen yet
  std::shared_ptr<const GroundExposure> sky;       // null: none, or not computed yet
  std::optional<double> known;  // share of the ground whose sunlight is known; empty: not observed yet
};
// Adds it to a layer's appearance. BLOCKS for some milliseconds.
void light_ground(ObjectAppearance& appearance, const GroundLook& ground);
// Whether a layer drawn under the one looks the same under the other.
bool look_alike(const GroundLook& now, const GroundLook& drawn);

// What was learnt of the ground, to be kept over a restart.
struct LearntGround {
  std::string ground;                // which: camera, model and place; what was learnt of another is of no use
  std::vector<std::uint8_t> shares;  // as GroundMemory has it
};

class GroundWatch {
 public:
  // `model` is used only here.
  GroundWatch(const Camera& scene, const Model& model, const Placement& placement);

  bool empty() const { return places_.empty(); }  // the model has no ground, or it is not seen
  std::size_t places() const { return places_.size(); }

  // BLOCKS for some milliseconds. `measured`: light from infinity in the picture; `appearance` says what light falls on
  // the ground and what air is before it.
  void see(const PictureView& picture, const FrameMetadata& metadata, const ObjectAppearance& appearance,
           const AirlightGrid& measured);
  // Goes on with the shade at the foot, for some tens of milliseconds or, `whole`, until it is done.
  void shade_foot(bool whole);
  GroundLook look() const { return look_; }

  const std::string& ground() const { return ground_; }
  int lessons() const { return memory_ ? memory_->lessons() : 0; }  // grows with what was learnt
  LearntGround learnt() const;                                      // needs a lesson
  // Before the first picture; since_s: from the last that was learnt from to now. Errors: bad_input (of another ground,
  // damaged, or it has seen a picture): nothing changes.
  Result<> resume(const LearntGround& learnt, double since_s);

 private:
  struct Place {
    int column = 0, row = 0;  // of the grid
    glm::dvec2 pixel{};
    glm::dvec3 direction{};  // from the camera
    glm::dvec3 normal{0, 0, 1};
    double range_m = 0.0;
    int left = 0, top = 0, right = 0, bottom = 0;  // its pixels
  };
  void find_places(const Camera& scene, const Model& model, const glm::dmat4& to_world);
  std::string name_ground() const;
  std::vector<float> supposed_reflectance(const glm::dmat3& albedo_to_channels) const;
  std::optional<double> light_of(const Place& place, const PictureView& picture) const;

  std::array<double, 256> green_{};  // linear light of an encoded value
  GroundSunlight grid_;              // its geometry
  std::vector<Place> places_;
  std::vector<glm::dvec3> base_colours_;  // of the places
  std::string ground_;
  struct Resumed {
    std::vector<std::uint8_t> shares;
    double since_s = 0.0;
  };
  std::optional<Resumed> resumed_;  // until the first picture
  std::optional<GroundMemory> memory_;
  std::optional<FootShadeWork> work_;
  GroundLook look_;
};

// The render loop's request, with a picture.
struct GroundQuestion {
  std::shared_ptr<GroundWatch> watch;
  std::shared_ptr<const ObjectAppearance> appearance;
  AirlightGrid measured;
};

}  // namespace kasumi
