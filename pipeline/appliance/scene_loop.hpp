// The scene camera's loop: hands its newest frame to the render loop.
#pragma once

#include "pipeline/appliance/camera_link.hpp"

namespace kasumi {

class SceneLoop {
 public:
  SceneLoop(ContentPtr content, Devices& devices, Clock& clock, Mailboxes& mailboxes);
  // BLOCKS until a frame has been forwarded or the deadline passes.
  void step(Instant deadline);

 private:
  void adopt_content();
  void forward(Frame frame);
  void publish();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  CameraLink camera_;
  std::optional<Instant> published_at_;
  std::uint64_t published_outages_ = 0;
  PictureCondition published_condition_ = PictureCondition::normal;
};

}  // namespace kasumi
