// Our processor time for a picture beside that of other programs which show the same frames (`kasumi bench --peers`).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

struct PeerRows {
  std::vector<BenchRow> rows;
  std::vector<std::string> skipped;  // "mpv: not installed"
};

// Plays the scene camera's JPEG frames of a fixture, over and over, in a window: with building and air by this program,
// as a plain video by GStreamer and mpv. Without a desktop a virtual one is started (Xvfb). Processor time is that of
// the players alone, start and end taken off by playing few and many pictures.
// Errors: bad_input (the fixture; its frames are not JPEG), unsupported (no desktop and no Xvfb), io.
Result<PeerRows> bench_peers(const std::filesystem::path& fixture);

}  // namespace kasumi
