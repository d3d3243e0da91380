#include "gles/display/display_listing.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include <fmt/ranges.h>

#include "base/statistics.hpp"
#include "gles/display/kms_plane_choice.hpp"
#include "gles/display/kms_system.hpp"
#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

constexpr Duration kLongestWait = std::chrono::seconds(5);

std::string name_of(KmsConnection connection) {
  switch (connection) {
    case KmsConnection::connected: return "connected";
    case KmsConnection::disconnected: return "disconnected";
    case KmsConnection::unknown: break;
  }
  return "unknown";
}

ListedConnector listed(const KmsConnector& connector) {
  ListedConnector made;
  made.name = connector.name;
  made.connection = name_of(connector.connection);
  made.display = connector.display;
  if (connector.mode_now) made.mode_now = connector.mode_now->text();
  for (const KmsMode& mode : connector.modes) {
    made.modes.push_back(mode.text());
    if (mode.preferred && made.preferred.empty()) made.preferred = made.modes.back();
  }
  if (made.preferred.empty() && !made.modes.empty()) made.preferred = made.modes.front();
  return made;
}

// YUV counts where the planes can convert every kind of it.
Result<> takes(const std::vector<KmsPlane>& planes, std::uint32_t primary, PixelLayout layout) {
  if (!is_yuv(layout)) {
    const auto pairs = choose_planes(planes, primary, drm_format_of(layout), std::nullopt);
    return pairs ? Result<>() : fail(pairs.error());
  }
  for (const auto encoding :
       {YuvEncoding::bt601_full, YuvEncoding::bt601_limited, YuvEncoding::bt709_full, YuvEncoding::bt709_limited})
    if (choose_planes(planes, primary, drm_format_of(layout), encoding)) return {};
  return fail(FaultKind::unsupported, "no plane converts {}", name_of(layout));
}

// Those of the building's layer and of a camera's pictures.
constexpr std::array<const char*, 12> kNamedFormats{"AR24", "AB24", "XR24", "XB24", "RG24", "BG24",
                                                    "NV12", "YU12", "YV12", "YU16", "YUYV", "UYVY"};

// "overlay: AR24 XR24 NV12 and 9 others; premultiplied; height 1 to 7; converts bt709_limited".
std::string text_of(const KmsPlane& plane) {
  std::vector<std::string> named;
  for (const auto format : plane.formats)
    if (auto name = drm_format_text(format); std::ranges::find(kNamedFormats, name) != kNamedFormats.end())
      named.push_back(std::move(name));
  std::string text = plane.kind == KmsPlane::Kind::primary   ? "primary"
                     : plane.kind == KmsPlane::Kind::overlay ? "overlay"
                                                             : "cursor";
  text += fmt::format(": {}", fmt::join(named, " "));
  if (plane.formats.size() > named.size()) text += fmt::format(" and {} others", plane.formats.size() - named.size());
  if (!plane.free) text += "; in use";
  text += !plane.premultiplied   ? "; blending not said"
          : *plane.premultiplied ? "; premultiplied"
                                 : "; not premultiplied";
  if (!plane.zpos)
    text += "; height not said";
  else if (plane.zpos->fixed)
    text += fmt::format("; height {}", plane.zpos->now);
  else
    text += fmt::format("; height {} to {}", plane.zpos->least, plane.zpos->most);
  std::vector<std::string_view> encodings;
  for (const auto encoding : plane.encodings) encodings.push_back(name_of(encoding));
  if (!encodings.empty()) text += fmt::format("; converts {}", fmt::join(encodings, ", "));
  return text;
}

void list_planes(KmsDevice& device, const std::vector<KmsConnector>& connectors, ListedCard& card) {
  const auto shown = std::ranges::find_if(connectors, [](const KmsConnector& connector) {
    return connector.connection == KmsConnection::connected && !connector.modes.empty();
  });
  if (shown == connectors.end()) return;
  const auto pipe = device.find_pipe(*shown, shown->modes.front());
  const auto planes = pipe ? device.planes(*pipe) : fail(pipe.error());
  if (planes) std::ranges::transform(*planes, std::back_inserter(card.planes), text_of);
  if (!device.has_atomic())
    card.no_planes = "the driver has no atomic commits";
  else if (!planes)
    card.no_planes = planes.error().what;
  if (!card.no_planes.empty()) return;
  for (const auto layout :
       {PixelLayout::bgra8, PixelLayout::rgba8, PixelLayout::bgr8, PixelLayout::rgb8, PixelLayout::nv12,
        PixelLayout::i420, PixelLayout::i422, PixelLayout::yuyv, PixelLayout::uyvy}) {
    const auto taken = takes(*planes, pipe->plane, layout);
    if (taken)
      card.plane_formats.push_back(drm_format_text(drm_format_of(layout)));
    else if (card.no_planes.empty())
      card.no_planes = taken.error().message;
  }
  if (!card.plane_formats.empty()) card.no_planes.clear();
}

}  // namespace

std::vector<ListedCard> list_displays(KmsSystem& system) {
  std::vector<ListedCard> cards;
  for (const KmsCardPlace& place : system.cards()) {
    ListedCard card;
    card.path = place.path;
    card.by_path = place.by_path;
    card.users = system.users_of(place.path);
    if (auto device = system.open_card(place.path); !device) {
      card.problem = device.error().what;
    } else {
      (*device)->drop_master();
      card.driver = (*device)->driver();
      card.atomic = (*device)->has_atomic();
      if (const auto connectors = (*device)->connectors(); !connectors) {
        card.problem = connectors.error().what;
      } else {
        std::ranges::transform(*connectors, std::back_inserter(card.connectors), listed);
        list_planes(**device, *connectors, card);
      }
    }
    cards.push_back(std::move(card));
  }
  return cards;
}

std::vector<ListedCard> list_displays() {
  return list_displays(*open_kms_system());
}

Result<FlipTiming> measure_flips(Display& display, Clock& clock, int count) {
  if (count < 2) return fail(FaultKind::bad_input, "{} flips to measure: expected 2 or more", count);
  std::map<std::uint64_t, Instant> shown_at;
  std::vector<Flip> flips;
  const auto take = [&] {
    for (const Flip& flip : display.take_flips())
      if (shown_at.contains(flip.number)) flips.push_back(flip);
  };
  for (int i = 0; i < count; ++i) {
    const auto target = display.begin(clock.now() + kLongestWait);
    if (!target) return fail(target.error());
    take();
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    const float grey =
        0.25f + 0.001f * static_cast<float>(i % 2);  // differs from the last one, so that no driver skips it
    glClearColor(grey, grey, grey, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    const Instant now = clock.now();
    const auto number = display.show();
    if (!number) return fail(number.error());
    shown_at[*number] = now;
  }
  // begin() returns once the last picture is shown.
  if (const auto settled = display.begin(clock.now() + kLongestWait); !settled) return fail(settled.error());
  take();

  if (flips.size() < 2) return fail(FaultKind::timeout, "{} of {} pictures reached the display", flips.size(), count);
  std::vector<Duration> intervals, latencies;
  for (const Flip& flip : flips) latencies.push_back(flip.at - shown_at[flip.number]);
  for (std::size_t i = 1; i < flips.size(); ++i) intervals.push_back(flips[i].at - flips[i - 1].at);
  return FlipTiming{static_cast<int>(flips.size()), median(intervals), std::ranges::max(intervals), median(latencies)};
}

}  // namespace kasumi
