// The air before the part in each picture, by everything but the part itself.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/result.hpp"
#include "pipeline/lab/prove/proof_inputs.hpp"

namespace kasumi {

struct AirByOthers {
  glm::dvec3 per_m{0.0}, sigma_per_m{0.0};  // extinction along a level path, by channel
  std::string unknown;                      // why it is unknown; empty: it is known
};

// By the other landmarks, all pictures together.
std::vector<AirByOthers> air_by_landmarks(const ProofInputs& scene);
// By a table with utc and extinction_g_per_m, and where known extinction_r_per_m, extinction_b_per_m and
// extinction_sigma_per_m: the row nearest in time, at most half an hour away. Errors (bad_input): all problems of the table.
Result<std::vector<AirByOthers>> air_by_table(const ProofInputs& scene, const std::filesystem::path& table);

}  // namespace kasumi
