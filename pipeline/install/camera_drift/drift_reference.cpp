#include "pipeline/install/camera_drift/drift_reference.hpp"

#include <utility>

#include "base/statistics.hpp"
#include "pipeline/install/camera_drift/reference_views.hpp"

namespace kasumi {
namespace {

DomeFrame median_look(const std::vector<DomeFrame>& looks) {
  DomeFrame still(looks[0].width(), looks[0].height());
  std::vector<float> values(looks.size());
  for (std::size_t i = 0; i < still.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < looks.size(); ++k) values[k] = looks[k].elements()[i][c];
      still.elements()[i][c] = median_in_place(values);
    }
  return still;
}

ViewReference reference_of(const GreyImage& still, const Camera& camera, Image<std::uint8_t> usable_shrunk,
                           const Image<std::uint8_t>& usable) {
  auto reference = reference_of(shrunk_view(still, camera, std::move(usable_shrunk)), camera);
  reference.edges = find_edges(light_of(still, camera), usable);
  return reference;
}

}  // namespace

ViewReference reference_of(const ShrunkView& view, const Camera& camera) {
  return {lines_of(*camera.lens, view), darkest_places(*camera.lens, view).value_or(DarkPlaces{}), {}};
}

DomeShade dome_reference(const DomeFrame& still, const Camera& sky, const std::vector<Direction>& suns) {
  return shade_of(still, open_sky(sky, still.width(), still.height(), suns));
}

Result<DriftReference> take_reference(const DriftFrames& frames, const Installation& installation, Utc now) {
  const auto enough = [](const auto& pictures) { return pictures.size() >= std::size_t{kFewestCheckFrames}; };
  if (!enough(frames.scene()) && !enough(frames.sky()))
    return fail(FaultKind::bad_input, "{} pictures of the scene, {} of the sky: expected at least {} of one of them",
                frames.scene().size(), frames.sky().size(), kFewestCheckFrames);
  DriftReference reference;
  reference.taken = now;
  reference.scene_calibrated = installation.scene.calibrated_utc;
  reference.sky_calibrated = installation.sky.calibrated_utc;
  if (enough(frames.scene())) reference.scene = reference_of(median_of(frames.scene()), installation.scene, {}, {});
  if (enough(frames.sky())) {
    const auto& sky = installation.sky;
    reference.sky = reference_of(median_of(frames.sky()), sky, still_part_of_sky(sky, shrink_factor(sky)),
                                 still_part_of_sky(sky, 1));
    reference.suns = frames.sun_places();
    reference.dome = dome_reference(median_look(frames.dome()), sky, reference.suns);
  }
  reference.turbidity = median_if_enough(frames.turbidities());
  reference.level = median_if_enough(frames.levels());
  return reference;
}

bool belongs_to(const DriftReference& reference, const Installation& installation) {
  const auto fits = [](const std::optional<ViewReference>& view, const Camera& camera) {
    const int factor = shrink_factor(camera);
    return !view || (view->lines.strength.width() == camera.width / factor &&
                     view->lines.strength.height() == camera.height / factor);
  };
  return reference.scene_calibrated == installation.scene.calibrated_utc &&
         reference.sky_calibrated == installation.sky.calibrated_utc && fits(reference.scene, installation.scene) &&
         fits(reference.sky, installation.sky);
}

std::filesystem::path reference_stem(const Installation& installation, const std::filesystem::path& root_file) {
  auto stem = installation.calibration ? installation.calibration->file : root_file;
  return stem.replace_extension();
}

}  // namespace kasumi
