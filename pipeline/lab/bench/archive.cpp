// What a picture of an archive costs beside the decoding of its JPEG, in processor time.
#include <algorithm>
#include <filesystem>
#include <thread>

#include <unistd.h>

#include "base/files.hpp"
#include "base/picture_files/decode_picture.hpp"
#include "base/statistics.hpp"
#include "capture/codec/encode.hpp"
#include "pipeline/lab/bench/bench.hpp"
#include "pipeline/lab/bench/drawn_sky.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"
#include "pipeline/lab/photographs/steady_worker.hpp"

namespace kasumi {
namespace {

enum class BenchWeather { night, overcast, clear };

// Moon and Spencer's: at the horizon a third as bright as above. Encoded, a little bluish.
glm::dvec3 overcast_level(const Camera& camera, const glm::dvec2& pixel) {
  constexpr double kAbove = 0.45;  // of full scale
  const auto view = camera.direction_at(pixel);
  const double light = kAbove * (1.0 + 2.0 * std::max(0.0, view ? view->z : 0.0)) / 3.0;
  return 255.0 * camera.response.to_encoded(light * glm::dvec3{0.97, 1.0, 1.04});
}

// Noise as a small sensor has it: a smooth picture would be decoded too fast.
Image<Rgb8> under(BenchWeather weather, const Camera& camera, Image<Rgb8> sky) {
  std::uint32_t state = 1;
  for (int y = 0; y < sky.height(); ++y)
    for (int x = 0; x < sky.width(); ++x) {
      Rgb8& pixel = sky.at(x, y);
      if (pixel == Rgb8{}) continue;
      if (weather == BenchWeather::night) pixel = Rgb8{8};
      if (weather == BenchWeather::overcast) pixel = Rgb8(overcast_level(camera, {x, y}));
      for (auto* level : {&pixel.r, &pixel.g, &pixel.b}) {
        state = state * 1664525u + 1013904223u;
        const int noise = static_cast<int>(state >> 24) % 9 - 4;
        *level = static_cast<std::uint8_t>(std::clamp(*level + noise, 1, 255));
      }
    }
  return sky;
}

struct BenchFile {
  std::filesystem::path file;
  std::vector<std::uint8_t> bytes;
  PhotographSetup options;
};

Result<BenchFile> archive_picture(const std::filesystem::path& folder, int side, BenchWeather weather) {
  constexpr int kQuality = 90;
  const SunDirection sun = direction_from(from_degrees(58.4), from_degrees(180.0));
  Camera camera;
  auto clear = drawn_sky(side, camera, sun);
  const auto sky = under(weather, camera, std::move(clear));
  auto bytes = encode_jpeg(sky, kQuality, ChromaSubsampling::s420);
  if (!bytes) return fail(bytes.error());
  BenchFile picture{folder / "sky.jpg", std::move(*bytes), {}};
  picture.options.calibrated = camera;
  picture.options.sun = weather == BenchWeather::night ? direction_from(from_degrees(110.0), from_degrees(0.0)) : sun;
  picture.options.estimate.sky.every_model = true;
  if (auto written = write_file(picture.file, picture.bytes); !written) return fail(written.error());
  return picture;
}

void decode(const BenchFile& picture) {
  if (const auto header = picture_header(picture.bytes)) (void)decode_picture_file(*header, picture.bytes);
}

// Medians of processor seconds of both, in turn.
std::pair<double, double> seconds_beside_decoding(const BenchFile& picture, int pairs) {
  constexpr int kDecodings = 5;
  PhotographEstimator photographs(picture.options);
  const auto answer = [&] { (void)photographs.estimate_from(picture.file, std::nullopt); };
  answer();
  std::vector<double> whole, alone;
  for (int i = 0; i < pairs; ++i) {
    whole.push_back(processor_seconds_of(answer));
    alone.push_back(processor_seconds_of([&] {
                      for (int k = 0; k < kDecodings; ++k) decode(picture);
                    }) /
                    kDecodings);
  }
  return {median(std::move(whole)), median(std::move(alone))};
}

// How many times one worker's rate two have, by the processor time of each: what they take from each other.
double gain_of_two(const BenchFile& picture) {
  constexpr int kPictures = 10, kRounds = 5;
  const auto work = [&] {
    PhotographEstimator photographs(picture.options);
    for (int i = 0; i < kPictures; ++i) (void)photographs.estimate_from(picture.file, std::nullopt);
  };
  std::vector<double> gains;
  for (int i = 0; i < kRounds; ++i) {
    const double one = processor_seconds_of(work);
    const double two = processor_seconds_of([&] {
      std::thread beside(work);
      work();
      beside.join();
    });
    gains.push_back(2.0 * 2.0 * one / two);
  }
  return median(std::move(gains));
}

Result<std::vector<BenchRow>> archive_rows(const std::filesystem::path& folder) {
  struct Case {
    const char* name;
    BenchWeather weather;
  };
  constexpr Case kCases[] = {{"night", BenchWeather::night}, {"overcast", BenchWeather::overcast}};
  constexpr std::pair<const char*, int> kSides[] = {{"480 px", 480}, {"1 Mpx", 1000}};
  std::vector<BenchRow> rows;
  for (const auto& [size, side] : kSides) {
    for (const auto& [name, weather] : kCases) {
      const auto picture = archive_picture(folder, side, weather);
      if (!picture) return fail(picture.error());
      const auto [whole, alone] = seconds_beside_decoding(*picture, 15);
      rows.push_back({fmt::format("archive, {}, {} / decoding alone", size, name), whole / alone, "x", 1.25, true});
    }
    const auto picture = archive_picture(folder, side, BenchWeather::clear);
    if (!picture) return fail(picture.error());
    const auto [whole, alone] = seconds_beside_decoding(*picture, 15);
    rows.push_back(
        {fmt::format("archive, {}, air fitted, beside decoding", size), 1e3 * (whole - alone), "ms", 12.0, true});
    rows.push_back({fmt::format("  decoding alone, {}", size), 1e3 * alone, "ms", std::nullopt, true});
    if (side == kSides[0].second)
      rows.push_back({"archive, two pictures at a time / one", gain_of_two(*picture), "x", 1.9, false});
  }
  return rows;
}

}  // namespace

Result<std::vector<BenchRow>> bench_archive() {
  prepare_steady_work();
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("kasumi-bench-{}", ::getpid());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  auto rows = archive_rows(folder);
  std::filesystem::remove_all(folder, error);
  return rows;
}

}  // namespace kasumi
