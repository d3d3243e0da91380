#include "calib/board/board_collector.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"

namespace kasumi {

namespace {

constexpr double kStill_px = 0.6;  // between two frames; median over the corners
constexpr double kSharp = 0.16;    // steepest step between pixels over the whole contrast: a blur of 2.5 px
constexpr double kLeaning = 0.10;  // of ln size from one side of the board to the other
constexpr std::size_t kViews = 12, kMostViews = 60;
constexpr double kCovered = 0.8;
constexpr int kLit = 20;                // of 255
constexpr std::size_t kFewCorners = 2;  // that cover a cell

// Median motion of the common corners; large when few are common.
double moved_px(const BoardView& before, const BoardView& now) {
  std::vector<double> ways;
  for (std::size_t i = 0; i < now.pixels.size(); ++i)
    for (std::size_t k = 0; k < before.pixels.size(); ++k)
      if (glm::distance(now.on_board[i], before.on_board[k]) < 1e-9)
        ways.push_back(glm::distance(now.pixels[i], before.pixels[k]));
  return 2 * ways.size() >= now.pixels.size() && !ways.empty() ? median(std::move(ways)) : 1e9;
}

double square_m_of(const AnyBoard& board) {
  return std::visit([](const auto& any) { return any.square_m; }, board);
}

// Pairs of corners one square apart.
template <class F>
void for_neighbours(const BoardView& view, double square_m, const F& f) {
  for (std::size_t i = 0; i < view.pixels.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (std::abs(glm::distance(view.on_board[i], view.on_board[k]) - square_m) < 0.01 * square_m) f(i, k);
}

// The steepest step near each corner against the contrast there.
double sharpness(const Image<std::uint8_t>& grey, const BoardView& view, double square_m) {
  double nearest = 1e9;
  for_neighbours(view, square_m, [&](std::size_t i, std::size_t k) {
    nearest = std::min(nearest, glm::distance(view.pixels[i], view.pixels[k]));
  });
  const int reach = std::clamp(static_cast<int>(0.4 * nearest), 2, 8);
  std::vector<double> all;
  for (const auto& pixel : view.pixels) {
    const int cx = static_cast<int>(std::lround(pixel.x)), cy = static_cast<int>(std::lround(pixel.y));
    int low = 255, high = 0, steepest = 0;
    for (int y = cy - reach; y <= cy + reach; ++y)
      for (int x = cx - reach; x <= cx + reach; ++x) {
        if (!grey.contains(x, y) || !grey.contains(x + 1, y + 1)) continue;
        const int here = grey.at(x, y);
        low = std::min(low, here);
        high = std::max(high, here);
        steepest = std::max({steepest, std::abs(grey.at(x + 1, y) - here), std::abs(grey.at(x, y + 1) - here)});
      }
    all.push_back(high > low + 20 ? static_cast<double>(steepest) / (high - low) : 0.0);
  }
  return median(std::move(all));
}

// Which way ln(size of the squares) grows over the picture, over the whole of what is seen of the board.
std::optional<Lean> lean_of(const BoardView& view, double square_m) {
  glm::dvec2 low{1e9}, high{-1e9};
  for (const auto& pixel : view.pixels) {
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  const glm::dvec2 middle = 0.5 * (low + high), size = glm::max(high - low, glm::dvec2(1.0));
  // ln(area of the square's diagonal cross) = a + b x + c y by least squares.
  glm::dmat3 normal{0.0};
  glm::dvec3 right{0.0};
  for_neighbours(view, square_m, [&](std::size_t i, std::size_t k) {
    const glm::dvec2 at = (0.5 * (view.pixels[i] + view.pixels[k]) - middle) / size;
    const glm::dvec3 row{1.0, at.x, at.y};
    normal += glm::outerProduct(row, row);
    right += std::log(std::max(1e-3, glm::distance(view.pixels[i], view.pixels[k]))) * row;
  });
  if (!(std::abs(glm::determinant(normal)) > 1e-9)) return std::nullopt;
  const glm::dvec3 slope = glm::inverse(normal) * right;
  if (std::max(std::abs(slope.y), std::abs(slope.z)) < kLeaning) return std::nullopt;
  if (std::abs(slope.y) > std::abs(slope.z)) return slope.y < 0.0 ? Lean::left : Lean::right;
  return slope.z < 0.0 ? Lean::top : Lean::bottom;
}

int ninth_of(const BoardView& view, int width, int height) {
  glm::dvec2 mean{0.0};
  for (const auto& pixel : view.pixels) mean += pixel / static_cast<double>(view.pixels.size());
  const int x = std::clamp(static_cast<int>(3.0 * (mean.x + 0.5) / width), 0, 2);
  const int y = std::clamp(static_cast<int>(3.0 * (mean.y + 0.5) / height), 0, 2);
  return 3 * y + x;
}

std::array<std::size_t, kCoverageCells * kCoverageCells> corners_in_cells(const BoardView& view, int width,
                                                                          int height) {
  constexpr int kCells = kCoverageCells;
  std::array<std::size_t, kCells * kCells> cells{};
  for (const auto& pixel : view.pixels) {
    const int x = std::clamp(static_cast<int>((pixel.x + 0.5) / width * kCells), 0, kCells - 1);
    const int y = std::clamp(static_cast<int>((pixel.y + 0.5) / height * kCells), 0, kCells - 1);
    ++cells[static_cast<std::size_t>(y * kCells + x)];
  }
  return cells;
}

std::size_t known_at(int ninth, const std::optional<Lean>& lean) {
  return static_cast<std::size_t>(ninth * (kLeans + 1) + (lean ? 1 + static_cast<int>(*lean) : 0));
}

constexpr std::array<std::string_view, kLeans> kSides{"left side", "right side", "upper side", "lower side"};
constexpr std::array<std::string_view, 9> kPlaces{"upper left", "top",        "upper right", "left",       "middle",
                                                  "right",      "lower left", "bottom",      "lower right"};

}  // namespace

std::string_view message_of(BoardCollector::Found found) {
  switch (found) {
    case BoardCollector::Found::nothing: return "no board is seen";
    case BoardCollector::Found::moving: return "hold it still";
    case BoardCollector::Found::blurred: return "blurred: hold it still, add light, or adjust the focus";
    case BoardCollector::Found::known: return "this view is already covered";
    case BoardCollector::Found::taken: break;
  }
  return "taken";
}

BoardCollector::Found BoardCollector::look(const Image<std::uint8_t>& grey, const std::string& name) {
  width_ = grey.width();
  height_ = grey.height();
  look_for_light(grey);
  const auto before = std::move(seen_);
  seen_ = find_any_board(grey, board_, name, true);
  if (!seen_) return Found::nothing;
  if (!before || moved_px(*before, *seen_) > kStill_px) return Found::moving;
  if (!adds(*seen_)) return Found::known;
  if (sharpness(grey, *seen_, square_m_of(board_)) < kSharp) return Found::blurred;
  take(*seen_);
  views_.back().picture = std::make_shared<Image<std::uint8_t>>(grey);
  return Found::taken;
}

// A cell is lit once a good part of it has been brighter than black.
void BoardCollector::look_for_light(const Image<std::uint8_t>& grey) {
  constexpr int kPoints = 6;
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column) {
      auto& lit = lit_[static_cast<std::size_t>(row * kCells + column)];
      if (lit) continue;
      int bright = 0;
      for (int i = 0; i < kPoints * kPoints; ++i) {
        const double x = (column + (i % kPoints + 0.5) / kPoints) * width_ / kCells;
        const double y = (row + (i / kPoints + 0.5) / kPoints) * height_ / kCells;
        if (grey.at(std::min(width_ - 1, static_cast<int>(x)), std::min(height_ - 1, static_cast<int>(y))) > kLit)
          ++bright;
      }
      lit = 2 * bright > kPoints * kPoints;
    }
}

bool BoardCollector::adds(const BoardView& view) const {
  if (views_.size() >= kMostViews) return false;
  const auto cells = corners_in_cells(view, width_, height_);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] >= kFewCorners && !covered_[i]) return true;
  return !known_[known_at(ninth_of(view, width_, height_), lean_of(view, square_m_of(board_)))];
}

void BoardCollector::take(BoardView view) {
  const auto cells = corners_in_cells(view, width_, height_);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] >= kFewCorners) covered_[i] = lit_[i] = true;
  const auto lean = lean_of(view, square_m_of(board_));
  if (lean) leaned_[static_cast<std::size_t>(*lean)] = true;
  known_[known_at(ninth_of(view, width_, height_), lean)] = true;
  views_.push_back(std::move(view));
}

BoardCollector::Cell BoardCollector::cell(int column, int row) const {
  const auto i = static_cast<std::size_t>(row * kCells + column);
  return covered_[i] ? Cell::covered : lit_[i] ? Cell::bare : Cell::dark;
}

double BoardCollector::covered() const {
  const auto lit = std::ranges::count(lit_, true), covered = std::ranges::count(covered_, true);
  return lit > 0 ? static_cast<double>(covered) / static_cast<double>(lit) : 0.0;
}

bool BoardCollector::enough() const {
  return views_.size() >= kViews && covered() >= kCovered &&
         std::ranges::all_of(leaned_, [](bool done) { return done; });
}

std::string BoardCollector::advice() const {
  if (enough()) return "enough";
  std::array<int, 9> bare{};
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column)
      if (cell(column, row) == Cell::bare)
        ++bare[static_cast<std::size_t>(3 * (3 * row / kCells) + 3 * column / kCells)];
  const auto barest = std::ranges::max_element(bare);
  const auto lean = std::ranges::find(leaned_, false);
  std::string text;
  if (covered() < kCovered && *barest > 0)
    text = fmt::format("move the board to the {}", kPlaces[static_cast<std::size_t>(barest - bare.begin())]);
  if (lean != leaned_.end())
    text += fmt::format("{}tilt {}, its {} nearer", text.empty() ? "" : " and ", text.empty() ? "the board" : "it",
                        kSides[static_cast<std::size_t>(lean - leaned_.begin())]);
  return text.empty() ? "a few more views, anywhere" : text;
}

std::string BoardCollector::map() const {
  std::string text;
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const auto here = cell(column, row);
      text += here == Cell::covered ? " #" : here == Cell::bare ? " ." : "  ";
    }
    text += '\n';
  }
  return text;
}

}  // namespace kasumi
