#include "pipeline/show/stage/then_and_now.hpp"

#include <algorithm>
#include <cmath>

#include "base/words/texts.hpp"
#include "pipeline/show/scene/aged_report.hpp"
#include "pipeline/site/config/opening_hours.hpp"

namespace kasumi {

namespace {

// A light line with dark borders is seen on snow and on forest.
constexpr Rgba8 kEdgeLight{247, 246, 241, 235}, kEdgeDark{17, 19, 23, 150};

std::string_view air_text(const SkyReport& sky) {
  if (!sky.seen_air() || sky.air->supposed) return "hand.then_supposed";
  return sky.air->trustworthy ? "hand.then_measured" : "hand.then_earlier";
}

std::string_view text_key_of(BuildingView view) {
  switch (view) {
    case BuildingView::live: return {};
    case BuildingView::alone: return "hand.view_alone";
    case BuildingView::clear_air: return "hand.view_clear_air";
    case BuildingView::morning: return "hand.view_morning";
    case BuildingView::noon: return "hand.view_noon";
    case BuildingView::evening: return "hand.view_evening";
  }
  return {};
}

}  // namespace

std::string title_of(BuildingView view, Language language, const std::string& hour) {
  const auto key = text_key_of(view);
  if (key.empty()) return {};
  const std::string title(text_of(key, language));
  return hour.empty() ? title : fmt::format("{} ({})", title, hour);
}

std::string hour_of(BuildingView view, Utc now, const Site& site, const std::string& time_zone) {
  if (!is_another_hour(view)) return {};
  const Utc time = time_of(view, now, site);
  const auto wall = time_zone.empty() ? std::chrono::local_time<Duration>(time.time_since_epoch()) +
                                            from_seconds(240.0 * site.longitude_deg)
                                      : local_time(time_zone, time);
  const auto five = std::chrono::round<std::chrono::duration<int, std::ratio<300>>>(
      wall - std::chrono::floor<std::chrono::days>(wall));
  const std::chrono::hh_mm_ss clock(std::chrono::minutes(five) % std::chrono::hours(24));
  return fmt::format("{:02}:{:02}", clock.hours().count(), clock.minutes().count());
}

HandView hand_view(double bare, const SkyReport& sky, Language language, BuildingView view, const std::string& hour) {
  if (!(bare > 0.0) && view == BuildingView::live) return {};
  const auto air = view == BuildingView::clear_air ? "hand.then_supposed" : air_text(sky);
  std::string then(text_of(air, language));
  if (view != BuildingView::live) then = title_of(view, language, hour) + "\n" + then;
  return {bare, bare > 0.0 ? std::string(text_of("hand.now", language)) : std::string(), std::move(then)};
}

Result<> ThenAndNow::draw(Label& label, const std::string& text, double from, double to, double foot,
                          GlContext& context, const MessageStyle& letters, const DrawTarget& target) {
  const CaptionKey key{letters.language, letters.print, target.width};
  if (label.text != text || label.key != key) {
    label.text = text;
    label.key = key;
    label.picture.reset();
    auto style = label_style_of(letters, target.width, target.height);
    style.largest_width_px = std::max(64, target.width * 45 / 100);
    if (auto flat = FlatPicture::create(context, picture_of_words(text, letters, style)))
      label.picture = std::move(*flat);
  }
  if (!label.picture) return {};
  const double width = label.picture->width(), height = label.picture->height(),
               margin = std::max(target.height / 24.0, foot);
  // Also where it has no room: while the edge moves, nothing else on the screen shall.
  foot_ = std::max(foot_, std::ceil(margin + height + target.height / 48.0));
  if (to - from < width + target.height / 24.0) return {};
  const double left = std::round(std::clamp((from + to - width) / 2.0, 0.0, target.width - width));
  return label.picture->draw(target, {left, std::round(target.height - margin - height), width, height});
}

Result<> ThenAndNow::draw(GlContext& context, const HandView& view, const MessageStyle& letters,
                          const DrawTarget& target, double foot) {
  foot_ = foot;
  if (view.then.empty()) return {};
  const double edge = std::round(view.bare * target.width);
  if (auto drawn = draw(now_, view.now, 0.0, edge, foot, context, letters, target); !drawn) return drawn;
  if (auto drawn = draw(then_, view.then, edge, target.width, foot, context, letters, target); !drawn) return drawn;
  if (view.bare <= 0.0 || view.bare >= 1.0) return {};
  if (!edge_) {
    Image<Rgba8> line(3, 1, kEdgeDark);
    line.at(1, 0) = kEdgeLight;
    auto flat = FlatPicture::create(context, line);
    if (!flat) return fail(flat.error());
    edge_ = std::move(*flat);
  }
  const double width = 3.0 * std::max(1.0, std::round(target.height / 540.0));
  return edge_->draw(target, {edge - std::floor(width / 2.0), 0.0, width, static_cast<double>(target.height)});
}

}  // namespace kasumi
