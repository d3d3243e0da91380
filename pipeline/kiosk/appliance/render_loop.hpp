// The main thread's loop: steps the ladder, draws, and shows. It alone owns GL and the display.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/kiosk/appliance/next_stage.hpp"
#include "pipeline/kiosk/appliance/screen.hpp"
#include "pipeline/kiosk/appliance/snapshot_desk.hpp"
#include "pipeline/kiosk/loop/hang_watch.hpp"
#include "pipeline/kiosk/start/remembered_layer.hpp"
#include "pipeline/kiosk/visitor/visitor_desk.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/watchdog.hpp"

namespace kasumi {

class RenderLoop {
 public:
  RenderLoop(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, Mailboxes& mailboxes);

  // Does what is due and returns when to be called again unless the bell rings before. BLOCKS for at most a quarter of
  // a second (waiting for a buffer), and while a display is being opened for as long as its driver takes.
  Instant step();
  // Records the last flips and closes the display.
  void finish();
  bool closed() const { return closed_; }  // a person closed the window
  // Other content is needed: why this one cannot be drawn. Empty: it can.
  std::string refused() const { return screen_.refused(); }
  const Rung& rung() const { return status_.rung; }
  const RenderStatus& status() const { return status_; }  // current; published twice a second
  // What is on the glass, for tests.
  BuildingView shown_view() { return screen_.is_open() ? screen_.stage().scene().shown_view() : BuildingView::live; }
  // The display, for tests; null while there is none.
  Display* display() { return screen_.display(); }

 private:
  Instant take_step();
  void watch_loops();
  void read_mailbox();
  void read_sky();
  void follow_visitor();
  void take_content();
  void adopt_content();
  std::optional<FlatPicture> what_fades_into(const Content& content);
  void take_order();
  void prepare_next_stage();
  void answer(const std::optional<StageAnswer>& answer);
  LadderInput ladder_input() const;
  void update_rung();
  bool is_open() const;
  bool is_closed() const { return status_.rung.dark >= 1.0; }  // and faded to black
  Composition composition() const;
  std::string visible_message() const;
  std::vector<std::string> words() const;  // a line each: that somebody looks at the screen, and visible_message()
  bool is_due(Instant now) const;
  bool is_building_seen() const;
  bool can_begin_live() const;
  void keep_layer(Duration after);
  Snapshot snapshot_facts() const;

  void handle_screen_fault(const Fault& fault);
  void tell_television();
  bool turn_off_if_closed();
  void present();
  Result<Screen::OnPlanes> try_planes(const SceneFrame* frame, const DrawTarget& target);
  Result<std::uint64_t> compose(const SceneFrame* frame, const DrawTarget& target,
                                std::shared_ptr<const void> until_replaced);
  void good_picture_came();
  Result<> draw(const SceneFrame* frame, const DrawTarget& target);
  void refuse(const Fault& why);
  void record_flips();
  void discard_frames();
  void publish();

  ContentPtr content_;
  ContentPtr new_content_;                          // not yet adopted; null: none
  std::optional<StageOrder> order_;                 // not yet begun
  PixelLayout layout_ = PixelLayout::rgb8;          // of the scene camera's last picture
  std::optional<std::pair<int, int>> target_size_;  // of the display
  Clock& clock_;
  Mailboxes& mailboxes_;
  Watchdog watchdog_;
  Ladder ladder_;
  RenderStatus status_;
  Screen screen_;
  LayerRecall recall_;
  Instant layer_kept_at_;
  NextStage next_;  // its GL objects belong to the screen's context
  bool closed_ = false;
  const Instant started_;

  CameraStatus camera_;
  SkyStatus told_sky_, sky_;           // as it was told, and as it reads now
  std::optional<Instant> sky_as_of_;   // empty: nothing was told yet
  std::optional<SceneFrame> waiting_;  // not yet drawn
  std::optional<Instant> picture_at_;  // when the last good scene picture came
  std::optional<bool> television_on_;  // as it was last told to be
  int refused_in_a_row_ = 0;           // frames that could not be drawn

  LatencyWatch latency_;
  SnapshotDesk snapshots_;
  VisitorDesk visitor_;
  std::optional<Composition> shown_;
  std::optional<Instant> fading_since_;  // from one era to the next
  Instant turned_;                       // when the present step began
  Instant shown_at_;
  std::optional<Instant> published_at_;
  Instant minute_began_;
  HangWatch hangs_;  // the other loops
};

}  // namespace kasumi
