// The scene camera's loop: hands its newest frame to the render loop.
#pragma once

#include "pipeline/kiosk/appliance/camera_link.hpp"

namespace kasumi {

class SceneLoop {
 public:
  SceneLoop(ContentPtr content, Devices& devices, Clock& clock, Mailboxes& mailboxes);
  // BLOCKS until a frame has been forwarded or the deadline passes.
  void step(Instant deadline);

 private:
  void adopt_content();
  void forward(Frame frame);
  bool is_spared();
  void publish();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  CameraLink camera_;
  std::optional<Instant> published_at_;
  std::uint64_t published_outages_ = 0;
  PictureCondition published_condition_ = PictureCondition::normal;
  Instant arrived_at_{}, forwarded_at_{};  // the last picture; the last that was not spared
  int spared_ = 0;                         // since then
};

}  // namespace kasumi
