// How good the drawn building was, in numbers.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/lab/prove/proof.hpp"

namespace kasumi {

struct ErrorSummary {
  std::size_t pictures = 0;
  double median_255 = 0.0, p95_255 = 0.0, mean_255 = 0.0;
};

struct ClassSummary {
  std::string air_class;
  std::array<ErrorSummary, kProofWays.size()> ways;
};

struct ProofSummary {
  std::array<ErrorSummary, kProofWays.size()> ways;
  ErrorSummary with_left_out;       // under the estimated air, of all that have one, judged or not
  glm::dvec3 bias_255{0.0};         // median of drawn - seen, by channel
  double within_sigma_share = 0.0;  // of pictures and channels; 68 % if sigmas are right
  double worst_sigma = 0.0;
  double pixel_median_255 = 0.0;
  std::vector<ClassSummary> classes;                  // the most pictures first
  std::vector<std::pair<std::string, int>> left_out;  // reasons without their numbers, and how many
};
ProofSummary summary_of(const Proof& proof);

}  // namespace kasumi
