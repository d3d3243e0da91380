// Views of a board from a live camera, with advice (and a window) on the next view.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "calib/board/any_board.hpp"
#include "calib/board/board.hpp"
#include "capture/frame_source.hpp"

namespace kasumi {

struct BoardSessionControl {
  bool window = false;
  Duration longest{};                             // 0: until coverage suffices
  std::function<bool()> stop{};                   // polled between frames
  std::function<void(const std::string&)> say{};  // one or more lines for people
};

struct GatheredViews {
  std::vector<BoardView> views;
  int width = 0, height = 0;
  int frames = 0;     // examined
  std::string ended;  // why: "the picture is covered", "end of the recording", "stopped"
};

// Of each frame with a new view of the board the corners are kept, and the picture until the lens is fitted, in memory;
// nothing of the others. Damaged frames are skipped, and a disconnected camera is waited for.
// Errors: of the source and of the window; bad_input (the picture size changes).
Result<GatheredViews> gather_views(FrameSource& source, const AnyBoard& board, Clock& clock,
                                   const BoardSessionControl& options);

// Where the frames come from: a recording (its folder, or that of one of its cameras), or a Video4Linux device, which
// needs the size of its pictures. `clock` must outlive it. Errors (bad_input, device ...): as the source has them.
Result<std::unique_ptr<FrameSource>> open_live(const std::string& device_or_recording, const std::string& camera,
                                               const std::string& size, Clock& clock);
// The camera configured in kasumi.toml.
Result<std::unique_ptr<FrameSource>> open_configured(const std::string& config, const std::string& camera,
                                                     Clock& clock);

}  // namespace kasumi
