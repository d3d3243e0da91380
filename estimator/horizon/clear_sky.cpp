// Separates the clear sky above the land from clouds.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <glm/exponential.hpp>

#include "base/statistics.hpp"
#include "estimator/horizon/clear_horizon.hpp"
#include "estimator/horizon/strips.hpp"

namespace kasumi {
namespace {

// Of the picture's height: small enough to lie between a cloud's edges.
constexpr double kCellShare = 1.0 / 180.0;
// Stacks of cells in a strip, and sampled pixels in a cell. Where noise hides the difference between clear sky and
// clouds, the next larger cells are tried.
struct CellSize {
  int stacks, pixels;
};
constexpr std::array<CellSize, 3> kCellSizes{{{4, 32}, {2, 64}, {1, 128}}};  // tried from the finest
// Less clear sky than this may be chance: real clouds have uniform parts, too.
constexpr double kLeastShare = 0.25;              // of the cells
constexpr double kLeastColumns = 0.75;            // of the strips
constexpr Radians kFarthest = from_degrees(2.0);  // between a strip that shows none and one that does
constexpr double kDarkest = 1e-6;                 // keeps the logarithm of black finite

// A cell of the picture and its classification.
struct Cell {
  HorizonCell light;
  int y = 0;  // its lowest row
  int stack = 0;
  bool clipped = false;
};

struct Measurement {
  const HorizonPixels& scene;
  Radians middle_azimuth;
  CellSize size;
  int cell_height, margin, band;

  std::optional<Cell> cell(int x0, int x1, int y0, int y1) const {
    std::vector<double> channels[3];
    int seen = 0, clipped = 0;
    const int pixels = (x1 - x0) * (y1 - y0), stride = std::max(1, pixels / size.pixels);
    for (int i = 0; i < pixels; i += stride) {
      const int x = x0 + i % (x1 - x0), y = y0 + i / (x1 - x0);
      ++seen;
      if (scene.sky.at(x, y) == 0) continue;
      const glm::dvec3 light = scene.light_at(x, y);
      for (int c = 0; c < 3; ++c) channels[c].push_back(std::log(std::max(light[c], kDarkest)));
      clipped += scene.clipped_at(x, y) ? 1 : 0;
    }
    const auto direction = scene.camera.direction_at({0.5 * (x0 + x1 - 1), 0.5 * (y0 + y1 - 1)});
    const auto count = channels[0].size();
    if (!direction || count < 4 || 2 * count < static_cast<std::size_t>(seen)) return std::nullopt;
    Cell cell;
    cell.light.azimuth = std::remainder(azimuth_angle(*direction).value - middle_azimuth.value, 2.0 * kPi);
    cell.light.elevation = kPi / 2.0 - zenith_angle(*direction).value;
    const glm::dvec3 step = scene.log_step_at(x0, y0);
    for (int c = 0; c < 3; ++c) {
      const double middle = median(channels[c]);
      std::vector<double> off = channels[c];
      for (double& value : off) value -= middle;
      const double spread = std::max(robust_sigma(std::move(off)), step[c]);
      double sum = 0.0, squares = 0.0, agreeing = 0.0;
      for (const double value : channels[c]) {
        const double from_middle = value - middle;
        if (std::abs(from_middle) > 3.0 * spread) continue;
        sum += from_middle;
        squares += from_middle * from_middle;
        agreeing += 1.0;
      }
      const double mean = sum / agreeing, deviation = std::sqrt(std::max(0.0, squares / agreeing - mean * mean));
      cell.light.log_light[c] = middle + mean;
      // The error that rounding leaves in a mean, 1 sigma: .3 of a step where all pixels are equal, nothing where noise
      // dithers.
      const double waves = kPi * deviation / step[c];
      const double rounding = 0.3 * step[c] * std::exp(-2.0 * waves * waves);
      const double noise = std::hypot(deviation / std::sqrt(agreeing), rounding);
      cell.light.noise = std::max(cell.light.noise, noise);
    }
    cell.y = y1 - 1;
    cell.clipped = 2 * static_cast<std::size_t>(clipped) > count;
    return cell;
  }

  // Stack by stack from the left, each from top to bottom.
  std::vector<Cell> cells(const std::vector<HorizonStrip>& strips) const {
    std::vector<Cell> found;
    for (std::size_t s = 0; s < strips.size(); ++s) {
      const HorizonStrip& strip = strips[s];
      for (int k = 0; k < size.stacks; ++k) {
        const int x0 = strip.x0 + k * (strip.x1 - strip.x0) / size.stacks;
        const int x1 = strip.x0 + (k + 1) * (strip.x1 - strip.x0) / size.stacks;
        const int rows = (strip.edge - margin - strip.top + 1) / cell_height;
        for (int row = rows; row > 0 && x1 > x0; --row) {
          const int y1 = strip.edge - margin + 1 - (row - 1) * cell_height;
          if (auto seen = cell(x0, x1, y1 - cell_height, y1)) {
            seen->light.strip = static_cast<int>(s);
            seen->stack = static_cast<int>(s) * size.stacks + k;
            found.push_back(*seen);
          }
        }
      }
    }
    return found;
  }
};

using Use = std::vector<std::uint8_t>;  // one per cell

// Sky for certain, with no hills in it, though not all of it clear.
Use certain_sky(const Measurement& m, const std::vector<Cell>& cells, const std::vector<HorizonStrip>& strips) {
  Use use(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const HorizonStrip& strip = strips[static_cast<std::size_t>(cells[i].light.strip)];
    use[i] = cells[i].y <= strip.certain - m.margin && !cells[i].clipped ? 1 : 0;
  }
  return use;
}

// Extends the sky down to the land. Air in front of a hill is never brighter than air at infinity, so hills are darker
// than the clear sky would be there, most of all in red, where airlight is weakest. Light that drops no lower than
// the clear sky's belonged to a cloud. Each stack is cut where most cells above the cut are not dark and most below it
// are.
Use above_land(const Measurement& m, const std::vector<Cell>& cells, const ClearHorizon& clear, const Use& certain) {
  const auto dark = [&](const Cell& cell) {
    const glm::dvec3 residual = clear.residual(cell.light);
    return std::min(residual.x, (residual.x + residual.y + residual.z) / 3.0) < -clear.tolerance;
  };
  Use use = certain;
  for (std::size_t first = 0; first < cells.size();) {
    std::size_t end = first, cut = first;
    int score = 0, best = 0;
    for (; end < cells.size() && cells[end].stack == cells[first].stack; ++end) {
      score += certain[end] != 0 || !dark(cells[end]) ? 1 : -1;
      if (score <= best) continue;
      best = score;
      cut = end + 1;
    }
    const int lowest = cut == end ? cells[end - 1].y : cells[cut].y - m.cell_height - m.margin;
    for (std::size_t i = first; i < cut; ++i) {
      if (cells[i].y <= lowest && !cells[i].clipped) use[i] = 1;
    }
    first = end;
  }
  return use;
}

std::vector<HorizonCell> lights_of(const std::vector<Cell>& cells) {
  std::vector<HorizonCell> lights;
  for (const Cell& cell : cells) lights.push_back(cell.light);
  return lights;
}

// The lowest clear cells of one strip.
struct Column {
  double azimuth = 0.0, elevation = 0.0;
  glm::dvec3 residual{0};  // above the surface
  double agreed = 0.0;     // share of the cells used that are clear
  bool seen = false;       // enough of them; else the surface gives the light at the lowest sky
};

std::optional<Column> column_of(const Measurement& m, const std::vector<Cell>& cells, const Use& use,
                                const ClearHorizon& clear, int strip) {
  std::vector<const Cell*> usable;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].light.strip == strip && use[i] != 0) usable.push_back(&cells[i]);
  }
  if (usable.empty()) return std::nullopt;
  std::stable_sort(usable.begin(), usable.end(), [](const Cell* a, const Cell* b) { return a->y > b->y; });
  const auto wanted = static_cast<std::size_t>(m.size.stacks * std::max(2, m.band / m.cell_height));
  std::vector<const Cell*> lowest;
  std::size_t looked_at = 0;
  while (looked_at < usable.size() && lowest.size() < wanted) {
    const Cell* cell = usable[looked_at++];
    if (clear.is_clear(cell->light)) lowest.push_back(cell);
  }
  Column column;
  column.agreed = static_cast<double>(lowest.size()) / static_cast<double>(looked_at);
  column.seen = 2 * lowest.size() >= wanted;
  if (!column.seen)
    lowest.assign(usable.begin(), usable.begin() + static_cast<std::ptrdiff_t>(std::min(usable.size(), wanted)));
  const auto count = static_cast<double>(lowest.size());
  for (const Cell* cell : lowest) {
    column.azimuth += cell->light.azimuth / count;
    column.elevation += cell->light.elevation / count;
    if (column.seen) column.residual += clear.residual(cell->light) / count;
  }
  return column;
}

// The surface may bridge columns without clear sky if they are few and close to the others.
bool is_sure(const std::vector<Column>& columns) {
  const auto with_clear_sky =
      static_cast<double>(std::count_if(columns.begin(), columns.end(), [](const Column& c) { return c.seen; }));
  return with_clear_sky >= kLeastColumns * static_cast<double>(columns.size()) &&
         std::all_of(columns.begin(), columns.end(), [&](const Column& column) {
           return std::any_of(columns.begin(), columns.end(), [&](const Column& other) {
             return other.seen && std::abs(other.azimuth - column.azimuth) < kFarthest.value;
           });
         });
}

std::vector<HorizonColumn> columns_of(const Measurement& m, const std::vector<Column>& seen,
                                      const ClearHorizon& clear) {
  std::vector<HorizonColumn> columns;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    // Residuals of the neighbours against the surface count too, so that no step shows between them.
    glm::dvec3 residual{0};
    double total = 0.0;
    for (std::size_t j = i > 0 ? i - 1 : 0; seen[i].seen && j <= i + 1 && j < seen.size(); ++j) {
      if (!seen[j].seen) continue;
      const double share = i == j ? 2.0 : 1.0;
      residual += share * seen[j].residual;
      total += share;
    }
    if (total > 0.0) residual /= total;
    const double azimuth = std::remainder(m.middle_azimuth.value + seen[i].azimuth, 2.0 * kPi);
    columns.push_back({{azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth},
                       {kPi / 2.0 - seen[i].elevation},
                       glm::exp(clear.log_light(seen[i].azimuth, seen[i].elevation) + residual),
                       seen[i].agreed * (seen[i].seen ? 1.0 : 0.3)});
  }
  return columns;
}

struct FirstLook {
  bool clipped = false;  // the most of it: there is nothing to be measured
  std::vector<Cell> cells;
  std::vector<HorizonCell> lights;
  Use use;
  ClearHorizon clear;
};
// Empty: too noisy, or too little of it.
std::optional<FirstLook> first_look(const Measurement& m, const std::vector<HorizonStrip>& strips) {
  FirstLook look;
  look.cells = m.cells(strips);
  const auto clipped = std::ranges::count_if(look.cells, [](const Cell& cell) { return cell.clipped; });
  look.clipped = 2 * static_cast<std::size_t>(clipped) > look.cells.size();
  if (look.clipped) return look;
  look.lights = lights_of(look.cells);
  look.use = certain_sky(m, look.cells, strips);
  const auto clear = fit_clear_horizon(look.lights, look.use);
  if (!clear) return std::nullopt;
  look.clear = *clear;
  return look;
}

std::vector<HorizonColumn> measured(const Measurement& m, const std::vector<HorizonStrip>& strips, FirstLook look) {
  look.use = above_land(m, look.cells, look.clear, look.use);
  const auto clear = fit_clear_horizon(look.lights, look.use);
  if (!clear || clear->share < kLeastShare) return {};
  std::vector<Column> seen;
  for (int s = 0; s < static_cast<int>(strips.size()); ++s) {
    if (const auto column = column_of(m, look.cells, look.use, *clear, s)) seen.push_back(*column);
  }
  if (!is_sure(seen)) return {};
  return columns_of(m, seen, *clear);
}

}  // namespace

std::vector<HorizonColumn> clear_sky(const HorizonPixels& scene, const std::vector<HorizonStrip>& strips) {
  const Camera& camera = scene.camera;
  const auto middle = camera.direction_at({0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
  if (!middle) return {};
  const auto rows = [&](double share, int least) { return std::max(least, static_cast<int>(share * camera.height)); };
  for (const CellSize& size : kCellSizes) {
    // In small pictures cells are taller, so that their means are no noisier.
    const int cell_width = std::max(1, camera.width / (static_cast<int>(strips.size()) * size.stacks));
    const int least_rows = std::max(2, (size.pixels + cell_width - 1) / cell_width);
    const Measurement m{scene,
                        azimuth_angle(*middle),
                        size,
                        rows(kCellShare, least_rows),
                        rows(kHorizonMargin, 1),
                        rows(kHorizonBand, 4)};
    auto look = first_look(m, strips);
    if (look && look->clipped) return {};
    if (look) return measured(m, strips, std::move(*look));
  }
  return {};
}

}  // namespace kasumi
