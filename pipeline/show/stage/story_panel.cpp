#include "pipeline/show/stage/story_panel.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/show/stage/text_layout.hpp"
#include "pipeline/show/stage/text_plate.hpp"

namespace kasumi {
namespace {

constexpr double kPanelOpacity = 0.9;                         // a white sky behind leaves a contrast of 13
constexpr double kTitleOverText = 1.25;                       // as a heading in print
constexpr double kMostWidth_em = 34.0, kLeastWidth_em = 9.0;  // of the panel: lines of 60 letters read best
constexpr int kMostTitleLines = 2;                            // a longer one is a text
constexpr double kSmaller[]{1.0, 0.85, 0.7};  // tried in turn; smaller ones are not read from where visitors stand
constexpr int kLeastScreen_px = 64, kMostScreen_px = 16384;  // of any GPU's textures
constexpr double kLeastLine_px = 14.0;                       // below, letters of many scripts are no shapes

struct Room {
  double left, top, right, bottom;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

struct LaidStory {
  Room room;
  std::optional<TextLayout> title;
  TextLayout text;
  double side, above, between;  // margins

  double width() const {
    return std::min(std::ceil(std::max(title ? title->width() : 0.0, text.width()) + 2.0 * side),
                    std::floor(room.width()));
  }
  double height() const { return std::ceil(title_height() + text.height() + 2.0 * above); }
  double title_height() const { return title ? title->height() + between : 0.0; }
};

double usual_line(const PanelRequest& request) {
  const double usual = std::max(kLeastLine_px, std::min(request.width, request.height) / 30.0);
  const auto& reader = request.reader;
  return reader.large_print ? std::max(1.5 * usual, reader.pixels_per_degree * kLineOverEm) : usual;
}

// Beside the building, the preferred one first.
std::vector<Room> rooms_of(const PanelRequest& request) {
  const double width = request.width, height = request.height, margin = std::round(height / 24.0);
  const Room screen{margin, request.reader.seated ? std::ceil(height * 2.0 / 3.0) : margin, width - margin,
                    height - std::max(margin, request.foot)};
  const auto& box = request.building;
  // Without a building as if a third of the screen on the other side were one.
  const double gap = box ? margin / 2.0 : 0.0, part = request.reader.left_handed ? 1.0 / 3.0 : 2.0 / 3.0;
  const double from = box ? box->left - gap : width * part, to = box ? box->left + box->width + gap : width * part;
  std::vector<Room> rooms{{screen.left, screen.top, std::min(screen.right, std::floor(from)), screen.bottom},
                          {std::max(screen.left, std::ceil(to)), screen.top, screen.right, screen.bottom}};
  if (request.reader.left_handed) std::swap(rooms[0], rooms[1]);
  if (box) {
    rooms.push_back(
        {screen.left, std::max(screen.top, std::ceil(box->top + box->height + gap)), screen.right, screen.bottom});
    rooms.push_back({screen.left, screen.top, screen.right, std::min(screen.bottom, std::floor(box->top - gap))});
  }
  return rooms;
}

// Nothing: not even a line of it has room.
Result<std::optional<LaidStory>> laid_into(const Room& room, const PanelRequest& request, double line_px) {
  const double em = line_px / kLineOverEm, side = 0.8 * em, above = 0.6 * em, between = 0.35 * em;
  if (room.width() < kLeastWidth_em * em || room.height() < line_px + 2.0 * above) return std::nullopt;
  TextStyle style{request.font_file,        request.language,
                  kTitleOverText * line_px, std::min(room.width(), kMostWidth_em * em) - 2.0 * side,
                  kMostTitleLines,          true};
  std::optional<TextLayout> title;
  if (!request.title.empty()) {
    auto laid = TextLayout::of(request.title, style);
    if (!laid) return fail(laid.error());
    title = std::move(*laid);
  }
  style.line_px = line_px;
  const double left = room.height() - 2.0 * above - (title ? title->height() + between : 0.0);
  style.most_lines = std::min(kMostPanelLines, static_cast<int>(left / line_px));
  // Of scripts that tower higher fewer lines fit.
  for (; style.most_lines > 0; --style.most_lines) {
    auto text = TextLayout::of(request.text, style);
    if (!text) return fail(text.error());
    if (text->height() <= left)
      return std::optional(LaidStory{room, std::move(title), std::move(*text), side, above, between});
  }
  return std::nullopt;
}

std::size_t left_out_of(const LaidStory& laid) {
  return laid.text.left_out() + (laid.title ? laid.title->left_out() : 0);
}

// The first that holds all, else the one that leaves out least.
Result<std::optional<LaidStory>> best_of(const PanelRequest& request) {
  std::optional<LaidStory> best;
  for (const double smaller : kSmaller) {
    if (smaller < 1.0 && request.reader.large_print) break;
    const double line_px = std::max(smaller * usual_line(request), kLeastLine_px);
    for (const Room& room : rooms_of(request)) {
      auto laid = laid_into(room, request, line_px);
      if (!laid) return laid;
      if (!*laid) continue;
      if (left_out_of(**laid) == 0) return laid;
      if (!best || left_out_of(**laid) < left_out_of(*best)) best = std::move(**laid);
    }
  }
  return best;
}

Result<> check_request(const PanelRequest& request) {
  Problems problems;
  for (const int size : {request.width, request.height})
    if (size < kLeastScreen_px || size > kMostScreen_px)
      problems.add("story: a screen of {} x {}: expected {} to {} pixels", request.width, request.height,
                   kLeastScreen_px, kMostScreen_px);
  if (const std::size_t bytes = request.title.size() + request.text.size(); bytes > kMostPanelBytes)
    problems.add("story: {} bytes: expected {} at most", bytes, kMostPanelBytes);
  if (request.text.empty()) problems.add("story: no text");
  if (const double given = request.reader.pixels_per_degree; !(given >= 5.0 && given <= 500.0))
    problems.add("story: {} pixels a degree: expected 5 to 500", given);
  return problems.empty() ? Result<>{} : fail(problems.fault());
}

Result<Image<Rgba8>> drawn(const LaidStory& laid) {
  const int width = static_cast<int>(laid.width()), height = static_cast<int>(laid.height());
  auto coverage = laid.text.draw(width, height, laid.above + laid.title_height(), laid.side);
  if (!coverage) return fail(coverage.error());
  if (laid.title) {
    const auto title = laid.title->draw(width, height, laid.above, laid.side);
    if (!title) return fail(title.error());
    auto& all = coverage->elements();
    std::ranges::transform(all, title->elements(), all.begin(), [](auto a, auto b) { return std::max(a, b); });
  }
  return text_plate(*coverage, kPanelOpacity, 0.5 * laid.text.em_px());
}

// At the screen's edge that is the room's, level with the building where that leaves it whole.
FlatPlace place_of(const LaidStory& laid, const PanelRequest& request) {
  const Room& room = laid.room;
  const double width = laid.width(), height = laid.height();
  const auto& box = request.building;
  const double middle_x = box ? box->left + box->width / 2.0 : room.left;
  const double middle_y = box ? box->top + box->height / 2.0 : request.height / 2.0;
  const bool beside = !box || room.right <= box->left || room.left >= box->left + box->width;
  const double x = !beside                                    ? middle_x - width / 2.0
                   : (room.left + room.right) < request.width ? room.left
                                                              : room.right - width;
  const double y = beside ? middle_y - height / 2.0 : room.top;
  return {std::round(std::clamp(x, room.left, std::max(room.left, room.right - width))),
          std::round(std::clamp(y, room.top, std::max(room.top, room.bottom - height))), width, height};
}

void add_faults(const TextLayout& layout, std::vector<std::string>& faults) {
  for (const auto& word : layout.missing())
    faults.push_back(
        fmt::format("no installed font can show \"{}\"{}", word.text,
                    word.package.empty() ? "" : fmt::format(" (on Debian: apt install {})", word.package)));
}

}  // namespace

Result<StoryPanel> draw_story_panel(const PanelRequest& request) {
  if (auto sound = check_request(request); !sound) return fail(sound.error());
  const auto laid = best_of(request);
  if (!laid) return fail(laid.error());
  if (!*laid)
    return fail(FaultKind::unsupported, "story: no room for a panel beside the building on a screen of {} x {} pixels",
                request.width, request.height);
  StoryPanel panel;
  auto picture = drawn(**laid);
  if (!picture) return fail(picture.error());
  panel.picture = std::move(*picture);
  panel.place = place_of(**laid, request);
  panel.left_out = left_out_of(**laid);
  if ((*laid)->title) add_faults(*(*laid)->title, panel.faults);
  add_faults((*laid)->text, panel.faults);
  if (panel.left_out > 0) panel.faults.push_back(fmt::format("{} lines more than the panel shows", panel.left_out));
  return panel;
}

}  // namespace kasumi
