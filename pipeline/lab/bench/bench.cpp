#include "pipeline/lab/bench/bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"
#include "calib/camera.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "calib/light/radiometry.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/papers/reference_pixel.hpp"
#include "estimator/sky/preetham.hpp"
#include "estimator/turbidity/solver.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/lab/bench/drawn_sky.hpp"

namespace kasumi {

namespace {

// Samples of the model's own sky with an 8-bit camera's noise, 30 % of them cloud. Used for speed only.
std::vector<LuminanceSample> bench_samples(int count, Turbidity turbidity) {
  const SunDirection sun = direction_from(from_degrees(58.4), from_degrees(180.0));
  const PreethamSky model(turbidity, sun);
  std::mt19937_64 random(7);
  std::vector<LuminanceSample> samples;
  while (static_cast<int>(samples.size()) < count) {
    const Direction view =
        direction_from(Radians{std::acos(0.18 + 0.82 * uniform(random))}, Radians{2.0 * kPi * uniform(random)});
    const Radians gamma = angle_between(view, sun);
    if (gamma < from_degrees(10.0)) continue;
    const double cloud = uniform(random) < 0.3 ? 0.2 + uniform(random) : 0.0;
    const double log_luminance = std::log(model.luminance_ratio(view)) + 0.005 * (uniform(random) - 0.5) + cloud;
    samples.push_back({static_cast<float>(zenith_angle(view).value), static_cast<float>(gamma.value),
                       static_cast<float>(log_luminance), 0.004f, 0.002f});
  }
  return samples;
}

}  // namespace

double seconds_of(const std::function<void()>& work) {
  const auto started = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
}

double processor_seconds_of(const std::function<void()>& work) {
  const auto started = std::clock();
  work();
  return static_cast<double>(std::clock() - started) / static_cast<double>(CLOCKS_PER_SEC);
}

double least_seconds_of(const std::function<void()>& work, int times) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < times; ++i) least = std::min(least, seconds_of(work));
  return least;
}

double paired_ratio(const std::function<void()>& a, const std::function<void()>& b, int pairs) {
  a();
  b();
  std::vector<double> ratios;
  for (int i = 0; i < pairs; ++i) {
    const double first = seconds_of(a);
    ratios.push_back(first / seconds_of(b));
  }
  return median(std::move(ratios));
}

std::vector<BenchRow> bench_turbidity() {
  constexpr int kSamples = 100, kSolves = 30;  // a few at a time: within a slice of the machine's
  const auto samples = bench_samples(kSamples, {3.0});
  const auto robust = [&] {
    for (int i = 0; i < kSolves; ++i) (void)solve_turbidity(samples);
  };
  const auto papers = [&] {
    for (int i = 0; i < kSolves; ++i) (void)solve_by_reference_pixel(samples, 0);
  };
  robust();
  return {
      {"global robust turbidity, N = 100", kSamples * kSolves / least_seconds_of(robust, 200) / 1e6, "M points/s", 2.0,
       false},
      {"  the papers' reference pixel with RANSAC / ours", paired_ratio(papers, robust, 15), "x", std::nullopt, false}};
}

std::vector<BenchRow> bench_sky_answer() {
  const SunDirection sun = direction_from(from_degrees(58.4), from_degrees(180.0));
  Camera camera;
  const Image<Rgb8> pixels = drawn_sky(480, camera, sun);
  SkyObserver observer(camera);
  EstimateParameters every, papers;
  every.sky.every_model = true;
  const auto answer = [&](const EstimateParameters& options) {
    if (const auto picture = sky_picture(view_of(pixels), camera)) (void)observer.observe(*picture, sun, options);
  };
  const auto by_every_model = [&] { answer(every); };
  const auto by_preethams = [&] { answer(papers); };
  const double ratio = paired_ratio(by_every_model, by_preethams, 9);
  return {{"whole answer, 480 px, auto: one core", 1e3 * least_seconds_of(by_every_model, 25), "ms", 40.0, true},
          {"  all models of the sky / Preetham's alone", ratio, "x", std::nullopt, true}};
}

std::vector<BenchRow> bench_air() {
  const auto measure = spectral_measure(generic_sensitivity());
  const auto nodes = attenuation_nodes(measure);
  double worst = 0.0;
  for (double t = 1.7; t <= 20.0; t += 0.3)
    for (double s = 0.0; s <= 50e3; s += 500.0) {
      const OpticalPath path{s, s};
      const auto fast = attenuation(haze_coefficients(nodes, ScatteringModel::morales2017, Turbidity{t}), path);
      const auto slow = attenuation_reference(measure, ScatteringModel::morales2017, Turbidity{t}, path);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(fast[c] - slow[c]));
    }
  const auto haze = haze_coefficients(nodes, ScatteringModel::morales2017, Turbidity{3.0});
  glm::dvec3 sink{};
  const auto fast = [&] {
    for (int i = 0; i < 2000; ++i) sink += attenuation(haze, {10.0 * i, 10.0 * i});
  };
  const auto slow = [&] {
    for (int i = 0; i < 2000; ++i)
      sink += attenuation_reference(measure, ScatteringModel::morales2017, Turbidity{3.0}, {10.0 * i, 10.0 * i});
  };
  const double ratio = paired_ratio(slow, fast, 5);
  return {{"attenuation, K = 2: worst error, T 1.7..20, s <= 50 km", worst, "", 3e-4, true},
          {"  1 nm reference / K = 2, on the CPU", sink.x > 0 ? ratio : 0.0, "x", std::nullopt, false}};
}

}  // namespace kasumi
