// The proof for programs: proof.json in full, and the few lines that `kasumi doctor` reads.
#pragma once

#include <string>

#include "pipeline/lab/prove/proof_summary.hpp"

namespace kasumi {

std::string proof_json(const Proof& proof, const ProofSummary& summary, const std::string& made_utc);
// What `kasumi doctor` reports of it.
std::string remembered_proof(const Proof& proof, const ProofSummary& summary, const std::string& made_utc);
// A few lines for a terminal.
std::string proof_text(const Proof& proof, const ProofSummary& summary);

}  // namespace kasumi
