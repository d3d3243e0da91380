// What is kept of a median picture.
#pragma once

#include "pipeline/install/camera_drift/drift_reference.hpp"

namespace kasumi {

ViewReference reference_of(const ShrunkView& view, const Camera& camera);  // without edges: they need the whole picture
DomeShade dome_reference(const DomeFrame& still, const Camera& sky, const std::vector<Direction>& suns);

}  // namespace kasumi
