// `kasumi bench --board`: what an owner of a board may send, so that its path and its bounds are known. No camera is
// opened; no names of hosts, accounts, displays or files, no serial numbers and no addresses are in it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "capture/v4l2/decoders.hpp"
#include "gles/display/display_listing.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

struct BoardPlaces {
  std::filesystem::path sys = "/sys";
  std::filesystem::path proc = "/proc";
};

// Lines "what: value" of the machine itself: board, kernel, processor, memory.
std::string machine_text(const BoardPlaces& places = {});
// Of each card: what it drives, its planes and their limits, whether the GPU is needed.
std::string displays_text(const std::vector<ListedCard>& cards);
std::string decoders_text(const std::vector<V4l2Decoder>& decoders);

// A picture of full HD by each path, measured in turn.
struct BoardDrawing {
  std::string gl;              // its renderer and what it can do
  std::string path;            // what mixes pictures there by itself
  std::vector<BenchRow> rows;  // milliseconds by the clock, and what they are of a plain blit
};
// BLOCKS for 45 s at most, and for what a slow machine needs to draw each once. Errors: unsupported (no GL), device.
Result<BoardDrawing> draw_for_board();

// Prints it all as it becomes known.
void print_board(const std::string& version);

}  // namespace kasumi
