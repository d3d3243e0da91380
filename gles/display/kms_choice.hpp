// Chooses the connector and its mode.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/display/display.hpp"
#include "gles/display/kms_device.hpp"

namespace kasumi {

// The connector of that name, or with an empty name the first that has a display with modes. Errors, listing the
// connectors: bad_input (no connector of that name), disconnected (no display there, or it lists no modes).
Result<KmsConnector> choose_connector(const std::vector<KmsConnector>& connectors, const std::string& name);

// The mode of that size and rate (within 0.6 Hz, so that 60 also matches 59.94), progressive before interlaced; without
// a size the display's preferred mode. Errors: disconnected (no modes), bad_input (no such mode; lists those
// available).
Result<KmsMode> choose_mode(const KmsConnector& connector, const KmsDisplayOptions& options);

// "HDMI-A-1: DEL U2412M, 1920x1200@59.95 (preferred), 1920x1080@60.00, ..." for people.
std::string in_words(const KmsConnector& connector);

}  // namespace kasumi
