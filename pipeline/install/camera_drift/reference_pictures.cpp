#include "pipeline/install/camera_drift/reference_pictures.hpp"

#include <algorithm>
#include <array>

#include "pipeline/install/camera_drift/reference_views.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

// What earlier versions kept beside the reference.
constexpr const char *kScenePicture = ".check-scene.png", *kSkyPicture = ".check-sky.png",
                     *kDomePicture = ".check-dome.png";

std::filesystem::path kept(const std::filesystem::path& stem, const char* ending) {
  return stem.string() + ending;
}

// Kept shrunk to this size, grey and encoded.
std::optional<ShrunkView> kept_view(const std::filesystem::path& file, const Camera& camera,
                                    Image<std::uint8_t> usable) {
  const auto photograph = read_photograph(file);
  const int factor = shrink_factor(camera);
  if (!photograph || photograph->encoded.width() != camera.width / factor ||
      photograph->encoded.height() != camera.height / factor)
    return std::nullopt;
  const auto rgb = to_rgb8(*photograph);
  GreyImage grey(rgb.width(), rgb.height());
  std::transform(rgb.elements().begin(), rgb.elements().end(), grey.elements().begin(),
                 [](const Rgb8& c) { return c.g; });
  return ShrunkView{light_of(grey, camera), factor, std::move(usable)};
}

}  // namespace

bool keeps_pictures(const std::filesystem::path& stem) {
  std::error_code error;
  return std::filesystem::exists(kept(stem, kScenePicture), error) ||
         std::filesystem::exists(kept(stem, kSkyPicture), error) ||
         std::filesystem::exists(kept(stem, kDomePicture), error);
}

Result<> remove_kept_pictures(const std::filesystem::path& stem) {
  for (const auto* ending : {kScenePicture, kSkyPicture, kDomePicture}) {
    std::error_code error;
    std::filesystem::remove(kept(stem, ending), error);
    if (error)
      return fail(FaultKind::io, "{}: cannot be removed: {}; no picture is to be kept", kept(stem, ending).string(),
                  error.message());
  }
  return {};
}

std::optional<ViewReference> scene_of_kept_picture(const std::filesystem::path& stem, const Camera& scene) {
  const auto view = kept_view(kept(stem, kScenePicture), scene, {});
  return view ? std::optional(reference_of(*view, scene)) : std::nullopt;
}

std::optional<ViewReference> sky_of_kept_picture(const std::filesystem::path& stem, const Camera& sky) {
  const auto view = kept_view(kept(stem, kSkyPicture), sky, still_part_of_sky(sky, shrink_factor(sky)));
  return view ? std::optional(reference_of(*view, sky)) : std::nullopt;
}

std::optional<DomeShade> dome_of_kept_picture(const std::filesystem::path& stem, const Camera& sky,
                                              const std::vector<Direction>& suns) {
  const auto photograph = read_photograph(kept(stem, kDomePicture));
  if (!photograph) return std::nullopt;
  auto light = photograph->encoded;  // kept as the root of the light
  for (auto& value : light.elements()) value *= value;
  return dome_reference(light, sky, suns);
}

Result<> replace_kept_pictures(const std::filesystem::path& stem, const Installation& installation) {
  if (!keeps_pictures(stem)) return {};
  const auto reference = load_reference(stem, installation);
  return reference ? save_reference(*reference, stem) : remove_kept_pictures(stem);
}

}  // namespace kasumi
