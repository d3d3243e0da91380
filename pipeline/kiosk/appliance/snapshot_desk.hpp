// Snapshots as the render loop takes them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gles/gl/target.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"

namespace kasumi {

// A snapshot of what the glass shows, without its picture. `words`: a line each.
Snapshot snapshot_of(const RenderStatus& status, bool building, const std::vector<std::string>& words, Utc utc);

// A sharp picture may show people: the glass says so for some seconds first, and on the picture itself. Of one for the
// state page it says so on the picture, and for some seconds after.
class SnapshotDesk {
 public:
  // Long enough to read two lines and to step aside.
  static constexpr Duration kTold = std::chrono::seconds(3), kToldAfter = std::chrono::seconds(5);

  explicit SnapshotDesk(SnapshotMailbox& answers) : answers_(answers) {}

  void request(SnapshotKind kind, const RunConfig& config, Instant now);
  // A picture is wanted now.
  bool is_due(Instant now) const { return wanted_ && now >= due_; }
  // The notice to visitors; empty: none.
  std::string words(Instant now) const;
  // The words are on the glass.
  void told(Instant now);
  // Reads what was drawn to `target`. Errors: device.
  Result<> take(Snapshot about, const DrawTarget& target, Instant now);
  // The answer where nothing is on the screen.
  void give_none(Snapshot about);
  // What the configuration says about pictures for the state page.
  void allow_pages(bool allowed);
  const PagePictures& page_pictures() const { return pages_; }

 private:
  void answer(Snapshot snapshot);

  SnapshotMailbox& answers_;
  std::optional<SnapshotKind> wanted_;
  std::string words_;       // for a sharp one
  std::string page_words_;  // for the last one of the state page
  Instant page_told_until_ = Instant::min();
  PagePictures pages_;
  Instant due_{};
  bool told_ = false;
};

}  // namespace kasumi
