// What the landmarks' contrasts have turned out to be, kept on disk so that a restart does not begin at nothing.
#pragma once

#include <filesystem>

#include "base/result.hpp"
#include "estimator/landmark_air.hpp"

namespace kasumi {

// folder/landmarks.json, old or new but never half of one. Error: io.
Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder);
// false: nothing was saved there. Error (bad_input): of landmarks at other places or distances; not what save() writes.
// The watch then stays as it was.
Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder);

}  // namespace kasumi
