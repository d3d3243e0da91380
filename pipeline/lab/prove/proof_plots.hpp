// The proof's plots, as SVG inside the page.
#pragma once

#include <string>

#include "pipeline/lab/prove/proof.hpp"

namespace kasumi {

// The facade as drawn over the facade as seen, by channel.
std::string plot_drawn_over_seen(const Proof& proof);
// The error over the estimated extinction: under that air, without air, under T = 3.
std::string plot_errors_over_extinction(const Proof& proof);
// Seen and drawn green over the pictures in order of time.
std::string plot_over_time(const Proof& proof);

}  // namespace kasumi
