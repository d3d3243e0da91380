// Findings about a model without drawing it.
#pragma once

#include <string>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

// Whether its z seems to point up, as in Blender, CAD and survey programs, by two more of these signs than y has: it
// stands on 0 of that axis; it lies evenly about 0 of the other; its surface as a whole, which buildings and scans leave
// open below, faces that way; it lies flat on its lowest part. What is flat along z stands. A guess for a person to look at.
bool seems_z_up(const Model& model);

// Lines for a person: size, triangles, textures, extensions, up axis, ground, what was left out; then what is doubtful,
// each with what to do.
struct ModelFacts {
  std::vector<std::string> lines, doubts;
};
ModelFacts facts_of(const Model& model, UpAxis up);

}  // namespace kasumi
