// Reads a display's EDID.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kasumi {

// Maker and model ("DEL U2412M"); empty if the EDID is invalid. VESA E-EDID 1.4, section 3.
std::string edid_name(std::span<const std::uint8_t> edid);

// A hash of the EDID; 0 for none.
std::uint64_t edid_identity(std::span<const std::uint8_t> edid);

}  // namespace kasumi
