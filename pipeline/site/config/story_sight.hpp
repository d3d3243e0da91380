// Whether a story's place is seen from where the kiosk's camera stands.
#pragma once

#include <string>

#include "pipeline/site/config/installation.hpp"
#include "pipeline/site/config/visitor_content.hpp"

namespace kasumi {

// Why it is never seen: outside the picture, below the horizon, behind what stands before, or behind the building
// itself. Empty: some of it is seen. `place`: in the model's frame.
std::string why_unseen(const Installation& installation, const Model& model, const ModelBounds& place);

}  // namespace kasumi
