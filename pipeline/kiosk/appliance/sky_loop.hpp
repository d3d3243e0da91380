// The sky camera's loop: observes the sky once a second and keeps reporting the air while no picture comes.
#pragma once

#include "pipeline/kiosk/appliance/camera_link.hpp"
#include "pipeline/site/config/time_trust.hpp"

namespace kasumi {

class SkyLoop {
 public:
  SkyLoop(ContentPtr content, Devices& devices, Clock& clock, TimeWatch& time, Mailboxes& mailboxes,
          ObservationPlan options = {});
  // BLOCKS until a frame has been observed or the deadline passes; an estimate takes about a tenth of a second.
  void step(Instant deadline);

 private:
  void adopt_content();
  SunSource sun_source();
  void restore_air();
  void observe(const Frame& frame, SunSource sun_from);
  void hold_sun(SunCheck& sun);
  void report_without_frame(SunSource sun_from);
  void publish(SkyReport report, bool up, SunSource sun_from);
  void publish_health();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  TimeWatch& time_;
  Mailboxes& mailboxes_;
  ObservationPlan options_;
  CameraLink camera_;
  TimeTrust trust_;
  SkyWatch watch_;
  Instant started_;
  std::optional<Instant> observed_at_, published_at_, health_published_at_;
  bool air_restored_ = false;
  SunSource sun_from_ = SunSource::none;
  Duration recorded_utc_offset_{};  // recording's UTC minus the machine's
  struct SeenSun {
    SunCheck sun;
    Instant at;
  };
  std::optional<SeenSun> seen_sun_;
};

}  // namespace kasumi
