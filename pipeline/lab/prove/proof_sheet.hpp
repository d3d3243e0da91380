// The contact sheet: as seen, as drawn, and the difference.
#pragma once

#include <filesystem>

#include "pipeline/lab/prove/proof.hpp"

namespace kasumi {

// At most some two dozen of the judged pictures, from the clearest air to the thickest: the part and what stands around
// it; the same with the part drawn; drawn - seen, four times as large, on grey. Empty: none was judged.
Image<Rgb8> proof_sheet(const Proof& proof);

}  // namespace kasumi
