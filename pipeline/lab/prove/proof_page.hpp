// The proof for people: one self-contained page.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "pipeline/lab/prove/proof_summary.hpp"

namespace kasumi {

// HTML 5, UTF-8, no script, nothing fetched. `sheet`: proof_sheet's as PNG, or nothing; `made_utc`: ISO 8601.
std::string proof_page(const Proof& proof, const ProofSummary& summary, std::span<const std::uint8_t> sheet,
                       const std::string& made_utc);

}  // namespace kasumi
