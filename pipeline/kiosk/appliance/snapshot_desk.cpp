#include "pipeline/kiosk/appliance/snapshot_desk.hpp"

#include <fmt/format.h>

#include "gles/gl/offscreen.hpp"

namespace kasumi {

Snapshot snapshot_of(const RenderStatus& status, bool building, const std::vector<std::string>& words, Utc utc) {
  Snapshot facts;
  facts.shown = status.display.up ? name_of(status.rung.shown) : "nothing";
  facts.reason = status.display.up ? std::string(name_of(status.rung.trouble)) : "no display: " + status.display.cause;
  facts.utc = utc;
  facts.building = building;
  if (status.display.up) facts.words = fmt::format("{}", fmt::join(words, " / "));
  return facts;
}

void SnapshotDesk::request(SnapshotKind kind, const RunConfig& config, Instant now) {
  const bool refused = (kind == SnapshotKind::sharp && !config.snapshot.sharp) ||
                       (kind == SnapshotKind::page && !config.snapshot.screen_picture);
  if (refused) {
    Snapshot refusal;
    refusal.kind = kind;
    refusal.refused = true;
    return answer(std::move(refusal));
  }
  wanted_ = kind;
  told_ = false;
  words_.clear();
  due_ = now;
  if (kind == SnapshotKind::page) page_words_ = message_text(Message::page_picture, config.messages.language);
  if (kind != SnapshotKind::sharp) return;
  words_ = message_text(Message::sharp_snapshot, config.messages.language);
  due_ = Instant::max();
}

std::string SnapshotDesk::words(Instant now) const {
  if (wanted_ && !words_.empty()) return words_;
  return wanted_ == SnapshotKind::page || now < page_told_until_ ? page_words_ : std::string();
}

void SnapshotDesk::told(Instant now) {
  if (!wanted_ || words_.empty() || told_) return;
  told_ = true;
  due_ = now + kTold;
}

Result<> SnapshotDesk::take(Snapshot about, const DrawTarget& target, Instant now) {
  auto picture = read_back(target);
  if (!picture) return fail(picture.error());
  about.picture = std::move(*picture);
  about.screen_width = target.width;
  about.screen_height = target.height;
  if (wanted_ == SnapshotKind::page) {
    ++pages_.taken;
    pages_.last = about.utc;
    page_told_until_ = now + kToldAfter;
  }
  answer(std::move(about));
  return {};
}

void SnapshotDesk::give_none(Snapshot about) {
  if (wanted_) answer(std::move(about));
}

void SnapshotDesk::allow_pages(bool allowed) {
  pages_.allowed = allowed;
  answers_.for_page = allowed;
}

void SnapshotDesk::answer(Snapshot snapshot) {
  if (wanted_) snapshot.kind = *wanted_;
  wanted_.reset();
  answers_.taken.put(std::move(snapshot));
  answers_.bell.ring();
}

}  // namespace kasumi
