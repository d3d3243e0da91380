// The scene camera's thread: takes its frames and hands the newest to the render loop.
#pragma once

#include "pipeline/appliance/camera_link.hpp"

namespace kasumi {

class SceneLoop {
 public:
  SceneLoop(ContentPtr content, Devices& devices, Clock& clock, Mailboxes& mailboxes);
  // BLOCKS until a frame has been handed on or the deadline passes.
  void step(Instant deadline);

 private:
  void take_content();
  void hand_on(Frame frame);
  void tell();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  CameraLink camera_;
  std::optional<Instant> told_;
  std::uint64_t told_outages_ = 0;
  PictureCondition told_condition_ = PictureCondition::normal;
};

}  // namespace kasumi
