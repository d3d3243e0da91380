// Plays a fixture through the whole pipeline.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "pipeline/lab/recording/stage_times.hpp"
#include "pipeline/show/scene/scene_air.hpp"
#include "pipeline/site/config/sighting.hpp"

namespace kasumi {

struct ReplayRequest {
  std::filesystem::path fixture;             // a folder with fixture.toml
  std::optional<std::filesystem::path> out;  // a folder for PNGs, or a video file; turbidity.csv goes next to them
  bool window = false;
  bool realtime = false;  // at the recorded pace; the sky then runs in a thread of its own, as in the appliance
  std::optional<std::size_t> frames;  // stop after so many pictures
  AirRendering air;
  GivenAir given = {};  // takes precedence over the air in the fixture's [site]
  bool terms = false;   // next to each picture of a folder its airlight and its direct transmission
  double wipe = 0.0;    // left of this share of the width the camera's picture alone
  BuildingView view = BuildingView::live;
  bool overlay = false;  // grid, horizon, the building's axes and landmarks over the pictures
  Mixing mixing = Mixing::automatic;
};

struct ReplaySummary {
  std::string fixture;
  std::size_t pictures = 0;
  bool interrupted = false;  // by a signal, or its window was closed
  std::size_t sky_frames = 0;
  std::size_t usable_sky_frames = 0;
  std::map<std::string, std::size_t> skipped;  // frames by reason
  std::uint64_t dropped = 0;                   // sky reports superseded before drawing (realtime only)
  std::uint64_t layers_drawn = 0;
  std::optional<SkyReport> last;
  std::optional<AirQuality> air;  // of the same; empty: none was seen
  std::optional<Aerosol> given;   // the air, where it was given
  HorizonLight::Source horizon = HorizonLight::Source::none;
  std::string horizon_reason;
  Sighting sighting;  // where the building stands in the picture, or why it does not
  std::string gl_renderer;
  bool software_gl = false;
  bool processor_mixed = false;
  double seconds = 0.0;
  StageSeconds stages{};           // of all pictures; in real time only of those that are drawn
  std::vector<std::string> notes;  // of the model: what of it is left out; of depth_map; and of the renderer
};

// Without `realtime`: as fast as possible. The next pictures are decoded and their air estimated, and the last one is
// written, while this one is drawn; a few at a time, so that memory does not grow. The order is that of the recording,
// so that the same fixture gives the same pictures bit for bit. Errors: bad_input (fixture, model), unsupported (no GL, no display), io.
Result<ReplaySummary> replay(const ReplayRequest& request);

}  // namespace kasumi
