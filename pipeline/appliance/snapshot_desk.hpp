// Snapshots as the render loop takes them.
#pragma once

#include <optional>
#include <string>

#include "gles/gl/target.hpp"
#include "pipeline/appliance/mailboxes.hpp"

namespace kasumi {

// A sharp picture may show people: the glass says so for some seconds first, and on the picture itself.
class SnapshotDesk {
 public:
  static constexpr Duration kTold = std::chrono::seconds(3);

  explicit SnapshotDesk(SnapshotMailbox& answers) : answers_(answers) {}

  void request(SnapshotKind kind, const RunConfig& config, Instant now);
  // A picture is wanted now.
  bool is_due(Instant now) const { return wanted_ && now >= due_; }
  // What visitors are told; empty: nothing.
  std::string words() const { return wanted_ ? words_ : std::string(); }
  // The words are on the glass.
  void told(Instant now);
  // Reads what was drawn to `target`. Errors: device.
  Result<> take(Snapshot about, const DrawTarget& target);
  // Where nothing is on the glass.
  void give_none(Snapshot about);

 private:
  void answer(Snapshot snapshot);

  SnapshotMailbox& answers_;
  std::optional<SnapshotKind> wanted_;
  std::string words_;
  Instant due_{};
  bool told_ = false;
};

}  // namespace kasumi
