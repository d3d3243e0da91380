// Earlier versions kept STEM.check-scene.png, -sky.png and -dome.png: made into lines, then removed.
#pragma once

#include "pipeline/install/camera_drift/drift_reference.hpp"

namespace kasumi {

bool keeps_pictures(const std::filesystem::path& stem);
// Errors: io.
Result<> remove_kept_pictures(const std::filesystem::path& stem);

// What is kept now of the pictures kept then. Empty: missing or damaged.
std::optional<ViewReference> scene_of_kept_picture(const std::filesystem::path& stem, const Camera& scene);
std::optional<ViewReference> sky_of_kept_picture(const std::filesystem::path& stem, const Camera& sky);
std::optional<DomeShade> dome_of_kept_picture(const std::filesystem::path& stem, const Camera& sky,
                                              const std::vector<Direction>& suns);

}  // namespace kasumi
