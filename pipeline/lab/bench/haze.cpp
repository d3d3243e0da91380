#include "pipeline/lab/bench/haze.hpp"

#include <cmath>
#include <functional>

#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"
#include "pipeline/show/scene/haze_blur_for_gles.hpp"

namespace kasumi {
namespace {

constexpr double kWidest_px = 25.0;  // as H Sect 5.2

// One wall at one distance: uniform blur. Its texture does not affect the time.
struct Wall {
  Image<glm::vec3> light;
  HazeRange range;
  HazeOptics optics;
  Wall(int width, int height) : light(width, height) {
    range.range = Image<float>(width, height, 1.0F);
    range.steps_along_row = range.steps_down_column = Image<float>(width, height);
    range.farthest_m = 1.0;
    optics = haze_optics(0.0, 1.0, kWidest_px - 1.0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) light.at(x, y) = glm::vec3((x / 8 + y / 8) % 2 == 0 ? 0.8F : 0.2F);
  }
};

std::vector<BenchRow> on_cpu() {
  const Wall wall(1600, 1120);
  auto map = blur_map(wall.range, wall.optics);
  auto one_surface = map;  // as H's experiment: no depth at all
  one_surface.steps_along_row = one_surface.steps_down_column = {};
  const auto faded = attenuated(wall.light, wall.range.range, wall.optics, {1.0, 1.0, 1.0});
  float sink = 0.0F;
  const auto by = [&](DiffusionScheme scheme, const BlurMap& widths) {
    return [&, scheme] {
      const auto blurred = diffuse(scheme, faded, widths);
      if (blurred) sink += blurred->at(0, 0).r;
    };
  };
  const auto ours = by(DiffusionScheme::matched, one_surface), with_edges = by(DiffusionScheme::matched, map);
  auto copy = faded;
  const cv::Mat from(copy.height(), copy.width(), CV_32FC4, copy.elements().data());
  cv::Mat to;
  const auto gaussian = [&] {
    cv::GaussianBlur(from, to, {}, std::sqrt(kWidest_px * kWidest_px - 1.0), 0.0, cv::BORDER_REFLECT);
  };
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);  // ours has one
  const double to_gaussian = paired_ratio(ours, gaussian, 5);
  cv::setNumThreads(threads);
  const double edges = paired_ratio(with_edges, ours, 3);
  // The explicit scheme, by the same loops, takes seconds: Kasumi's is measured before and after it.
  std::vector<double> seconds;
  for (int i = 0; i < 10; ++i) seconds.push_back(processor_seconds_of(ours));
  const double explicit_seconds = processor_seconds_of(by(DiffusionScheme::explicit_steps, one_surface));
  for (int i = 0; i < 11; ++i) seconds.push_back(processor_seconds_of(ours));
  const double explicit_ratio = explicit_seconds / median(std::move(seconds));
  const auto few = cost_of(DiffusionScheme::matched, 1.0, kWidest_px),
             many = cost_of(DiffusionScheme::explicit_steps, 1.0, kWidest_px);
  return {{"haze of 25 px, 1600 x 1120, CPU: explicit scheme / ours, time", explicit_ratio, "x", 60.0, false},
          {"  the same, operations", many.operations() / few.operations(), "x", 60.0, false},
          {"  ours with edges of depth / without", edges, "x", std::nullopt, true},
          {"  ours / cv::GaussianBlur of one width, one thread", sink >= 0.0F ? to_gaussian : 0.0, "x", 0.4, true}};
}

Result<std::vector<BenchRow>> on_gpu() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const auto& info = (*context)->info();
  // A software rasterizer takes a minute for the explicit scheme on the whole picture.
  const int width = info.software ? 400 : 1600, height = info.software ? 280 : 1120;
  const Wall wall(width, height);
  std::vector<HazeBlur> blurs;
  for (const bool bytes : {false, true}) {
    auto made = HazeBlur::create(info, width, height, {bytes});
    if (!made) return fail(made.error());
    if (auto set = made->set_scene(haze_scene(wall.light, wall.range)); !set) return fail(set.error());
    blurs.push_back(std::move(*made));
  }
  const auto look = haze_look(wall.optics, wall.range, {1.0, 1.0, 1.0});
  const auto explicit_look = haze_look(wall.optics, wall.range, {1.0, 1.0, 1.0}, DiffusionScheme::explicit_steps);
  const auto run = [](HazeBlur& blur, const HazeLook& haze) { return [&] { return blur.run(haze); }; };
  Stopwatch watch;
  std::vector<BenchRow> rows;
  const double ratio_to_explicit = watch.ratio(run(blurs[0], explicit_look), run(blurs[0], look), 3);
  rows.push_back({fmt::format("haze of 25 px, {} x {}, GPU ({}): explicit scheme / ours, time", width, height,
                              blurs[0].in_bytes() ? "bytes" : "half floats"),
                  ratio_to_explicit, "x", 60.0, false});
  if (!blurs[0].in_bytes()) {
    const double ratio = watch.ratio(run(blurs[1], look), run(blurs[0], look), 5);
    rows.push_back({"  ours in bytes / in half floats", ratio, "x", std::nullopt, true});
  }
  if (!watch.result()) return fail(watch.result().error());
  return rows;
}

}  // namespace

Result<std::vector<BenchRow>> bench_haze() {
  auto rows = on_cpu();
  auto more = on_gpu();
  if (!more) return fail(more.error());
  rows.insert(rows.end(), more->begin(), more->end());
  return rows;
}

}  // namespace kasumi
