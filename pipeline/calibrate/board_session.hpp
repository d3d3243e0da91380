// Views of a board from a camera that runs, with words (and a window) on what the next should be.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "calib/board/any_board.hpp"
#include "calib/board/board.hpp"
#include "capture/frame_source.hpp"

namespace kasumi {

struct BoardSessionOptions {
  bool window = false;
  Duration longest{};                             // 0: until coverage suffices
  std::function<bool()> stop{};                   // asked between frames
  std::function<void(const std::string&)> say{};  // a line, or a few, for a person
};

struct GatheredViews {
  std::vector<BoardView> views;
  int width = 0, height = 0;
  int frames = 0;     // looked at
  std::string ended;  // why: "the picture is covered", "the recording is over", "stopped"
};

// Frames stay in memory, of each nothing but its corners; damaged ones are passed over. A camera that goes is waited
// for. Errors: of the source and of the window; bad_input (the camera changes its size).
Result<GatheredViews> gather_views(FrameSource& source, const AnyBoard& board, Clock& clock,
                                   const BoardSessionOptions& options);

// Where the frames come from: a recording (its folder, or that of one of its cameras), or a Video4Linux device, which
// needs the size of its pictures. `clock` must outlive it. Errors (bad_input, device ...): as the source has them.
Result<std::unique_ptr<FrameSource>> open_live(const std::string& device_or_recording, const std::string& camera,
                                               const std::string& size, Clock& clock);
// The camera that kasumi.toml names.
Result<std::unique_ptr<FrameSource>> open_configured(const std::string& config, const std::string& camera,
                                                     Clock& clock);

}  // namespace kasumi
