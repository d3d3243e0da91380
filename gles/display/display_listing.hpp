// Lists the machine's displays, for its operators.
#pragma once

#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "gles/display/display.hpp"

namespace kasumi {

struct ListedConnector {
  std::string name;        // "HDMI-A-1"
  std::string connection;  // "connected", "disconnected", "unknown"
  std::string display;     // "DEL U2412M"; empty: unknown
  std::string mode_now;    // "1920x1080@60.00"; empty: none
  std::string preferred;   // the preferred mode; empty: it lists no modes
  std::vector<std::string> modes;
};

struct ListedCard {
  std::string path;     // "/dev/dri/card0"
  std::string by_path;  // "/dev/dri/by-path/pci-0000:00:02.0-card"; empty: udev gives none
  std::string driver;   // "vc4"
  bool atomic = false;
  std::string users;    // "kasumi (pid 411) is master"; empty: none, or not visible to this account
  std::string problem;  // why the card could not be queried; then the fields above may be empty
  std::vector<ListedConnector> connectors;
  std::vector<std::string> plane_formats;  // of a camera's pictures that the first connected display may lay a building
                                           // over by itself: "XR24", "NV12"
  std::vector<std::string> planes;         // that the first connected display can show, and their limits
  std::string no_planes;                   // why there are none; empty: there are some, or no display is connected
};

// Every card that drives displays, or might. Does not disturb what is shown; BLOCKS for some 10 ms per connector.
std::vector<ListedCard> list_displays();

// How fast a display accepts pictures.
struct FlipTiming {
  int flips = 0;
  Duration median_interval{};  // between flips, with pictures offered as fast as the display accepts them
  Duration longest_interval{};
  Duration median_latency{};  // from show() to the flip
};
// Shows `count` plain grey pictures. BLOCKS until the last is shown. Errors: as the display's; bad_input for count < 2.
Result<FlipTiming> measure_flips(Display& display, Clock& clock, int count);

}  // namespace kasumi
