// What a display says about itself.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kasumi {

// Maker and model by a display's EDID ("DEL U2412M"); empty when it is none. VESA E-EDID 1.4, section 3.
std::string edid_name(std::span<const std::uint8_t> edid);

// A number that changes with the EDID; 0 for none.
std::uint64_t edid_identity(std::span<const std::uint8_t> edid);

}  // namespace kasumi
