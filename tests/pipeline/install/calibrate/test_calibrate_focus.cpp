// kasumi calibrate focus on a printed checkerboard as a generated camera films it: its blur, sharpening and noise are
// known, its JPEG is libjpeg's.
#include <cmath>

#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/table/config_table.hpp"
#include "calib/image_quality.hpp"
#include "calib/light/edge_fit.hpp"
#include "calib/light/stream_noise.hpp"
#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "capture/fixture/fixture_writer.hpp"
#include "fixtures/light/sensor.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr int kWide = 400, kTall = 300, kPictures = 6;
constexpr double kFullWell = 10000.0, kReadNoise = 3.0;  // of the generated sensor (fixtures/light/sensor.cpp)

// Grey squares of 34 px on paper, turned by 9 degrees, lit a little unevenly, behind a lens that blurs; light at full
// scale is 1. Blurred on a grid six times as fine, since a camera blurs before it has pixels.
Image<glm::dvec3> chart(double spread_px) {
  constexpr int kFine = 6;
  const double turn = 9.0 * kPi / 180.0, c = std::cos(turn), s = std::sin(turn);
  Image<double> fine(kFine * kWide, kFine * kTall);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x) {
      const double u = (x + 0.5) / kFine, v = (y + 0.5) / kFine;
      const int column = static_cast<int>(std::floor((c * u + s * v) / 34.0));
      const int row = static_cast<int>(std::floor((c * v - s * u) / 34.0 + 100.0));
      fine.at(x, y) = ((column + row) % 2 == 0 ? 0.06 : 0.42) * (0.8 + 0.4 * u / kWide);
    }
  const double sigma = kFine * spread_px;
  const int radius = static_cast<int>(std::ceil(4.0 * sigma));
  const auto pass = [&](const Image<double>& from, int dx, int dy) {
    Image<double> to(from.width(), from.height());
    for (int y = 0; y < from.height(); ++y)
      for (int x = 0; x < from.width(); ++x) {
        double sum = 0.0, weights = 0.0;
        for (int i = -radius; i <= radius; ++i) {
          if (!from.contains(x + i * dx, y + i * dy)) continue;
          const double weight = std::exp(-0.5 * i * i / (sigma * sigma));
          sum += weight * from.at(x + i * dx, y + i * dy);
          weights += weight;
        }
        to.at(x, y) = sum / weights;
      }
    return to;
  };
  fine = pass(pass(fine, 1, 0), 0, 1);
  Image<glm::dvec3> light(kWide, kTall);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x)
      light.at(x / kFine, y / kFine) += glm::dvec3(fine.at(x, y) / (kFine * kFine));
  return light;
}

Camera plain_scene_camera() {
  Camera camera;
  camera.width = kWide;
  camera.height = kTall;
  camera.response = Response::srgb();
  return camera;
}

// JPEG quality 0: none.
std::vector<Image<Rgb8>> filmed(const fixtures::Sharpness& sharpness, int quality,
                                std::shared_ptr<const JpegSteps>& steps) {
  auto light = chart(sharpness.point_spread_px);
  const fixtures::Exposure exposure;
  for (auto& value : light.elements()) value /= fixtures::kResponsivity * exposure.exposure_s;
  std::vector<Image<Rgb8>> pictures;
  for (int i = 0; i < kPictures; ++i) {
    fixtures::Exposure own = exposure;
    own.seed = static_cast<std::uint64_t>(100 + i);
    auto picture = fixtures::expose(light, plain_scene_camera(), own, {.sharpening = sharpness.sharpening});
    if (quality > 0) {
      const auto bytes = encode_jpeg(picture, quality, ChromaSubsampling::s420).value();
      const auto planes = decode_jpeg(bytes, kWide, kTall).value();
      picture = to_rgb(planes.view);
      steps = std::make_shared<const JpegSteps>(planes.steps);
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

Image<float> mean_of(const std::vector<Image<Rgb8>>& pictures) {
  Image<float> mean(kWide, kTall);
  for (const auto& picture : pictures)
    for (std::size_t i = 0; i < mean.elements().size(); ++i)
      mean.elements()[i] += static_cast<float>(
          glm::dot(glm::dvec3(0.299, 0.587, 0.114), glm::dvec3(picture.elements()[i])) / (255.0 * kPictures));
  return mean;
}

struct FilmedCamera {
  double spread_px, sharpening;
  int quality;
};

TEST(CalibrateFocus, FindsBlurSharpeningAndNoiseOfAGeneratedCamera) {
  std::vector<FilmedCamera> all;
  for (const int quality : {0, 92, 75})
    for (const double spread : {0.4, 0.6, 1.0})
      for (const double sharpening : {0.0, 0.8, 1.5}) all.push_back({spread, sharpening, quality});
  for (const FilmedCamera& given :
       figure_cases("cameras", {{0.6, 0.8, 0}, {0.6, 0.8, 92}, {0.6, 0.0, 75}, {0.4, 0.0, 92}}, all)) {
    std::shared_ptr<const JpegSteps> steps;
    const auto pictures = filmed({given.spread_px, given.sharpening}, given.quality, steps);
    const auto edges = find_drawn_edges(mean_of(pictures), Response::srgb());
    const auto found = sharpness_of(edges, Response::srgb(), steps.get());
    const auto words = fmt::format("{} px, sharpening {}, JPEG {}", given.spread_px, given.sharpening, given.quality);
    ASSERT_TRUE(found) << words << ": " << edges.size() << " edges";
    const auto noise = fit_stream_noise(pictures, Response::srgb(), {glm::dvec3{1.0}, found->sharpening, steps});
    ASSERT_TRUE(noise) << words;
    fmt::print("{}: {:.2f} +- {:.2f} px, {:.2f} +- {:.2f} of {} edges; {:.0f} electrons, read {:.1f}, misfit {:.2f}\n",
               words, found->point_spread_px, found->point_spread_sigma_px, found->sharpening, found->sharpening_sigma,
               found->edges, noise->full_scale_electrons, noise->read_electrons, noise->misfit);
    figure_row("calibrate-focus",
               {fmt::format("{} px, {}, {}", figure_text(given.spread_px, 1), figure_text(given.sharpening, 1),
                            given.quality == 0 ? "none" : std::to_string(given.quality)),
                figure_text(found->point_spread_px, 2), figure_text(found->sharpening, 2),
                fmt::format("{:.0f}", noise->full_scale_electrons)});
    EXPECT_NEAR(found->point_spread_px, given.spread_px, 0.07) << words;
    EXPECT_NEAR(found->sharpening, given.sharpening, std::max(0.2, 0.15 * given.sharpening)) << words;
    EXPECT_NEAR(std::sqrt(noise->full_scale_electrons / kFullWell), 1.0, 0.25) << words << ": the noise";
    EXPECT_LE(noise->read_electrons, 4.0 * kReadNoise) << words;
  }
}

// The command on a recording of that chart: what it writes is what a fixture reads.
TEST(CalibrateFocus, TheCommandWritesTheKeysThatTheSceneIsDrawnWith) {
  const auto folder = test_output_folder() / "pipeline/calibrate-focus";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "sky");
  auto writer = FixtureWriter::create(folder / "scene").value();
  std::shared_ptr<const JpegSteps> steps;
  std::int64_t second = 0;
  for (const auto& picture : filmed({.point_spread_px = 0.6, .sharpening = 0.8}, 0, steps)) {
    auto frame = encode_frame(picture, kMjpg, {.jpeg_quality = 92}).value();
    frame.metadata.utc = Utc(std::chrono::seconds(1790000000 + second));
    frame.metadata.captured_at = Instant(std::chrono::seconds(second));
    frame.metadata.sequence = static_cast<std::uint32_t>(second++);
    ASSERT_TRUE(writer.append(frame));
  }
  const std::string camera =
      fmt::format("width = {}\nheight = {}\nheading_deg = 0.0\npitch_deg = 0.0\nresponse = \"srgb\"\n", kWide, kTall);
  const std::string lens = "model = \"pinhole\"\nfocal_px = [600.0, 600.0]\ncentre_px = [199.5, 149.5]\n";
  ASSERT_TRUE(write_text_file(
      folder / "fixture.toml",
      "format = 1\nname = \"chart\"\ndescription = \"A chart.\"\nlicence = \"CC0-1.0\"\nprovenance = \"Generated\"\n"
      "start_utc = 2026-09-21T12:00:00Z\n[site]\nlatitude_deg = 34.0\nlongitude_deg = 135.0\naltitude_m = 900.0\n"
      "[sky]\n" +
          camera + "[sky.lens]\n" + lens + "[scene]\n" + camera + "[scene.lens]\n" + lens +
          "[object]\nmodel = \"chart.glb\"\neast_m = 0.0\nnorth_m = 900.0\nup_m = 0.0\n"));
  std::filesystem::copy(source_folder() / "fixtures/temple.glb", folder / "chart.glb");
  const auto out = folder / "calibration.toml";
  const auto outcome = run_kasumi(fmt::format("calibrate focus {} --out {}", folder.string(), out.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto root = ConfigTable::read_file(out).value();
  const auto quality = read_image_quality(root.table("scene"));
  EXPECT_NEAR(quality.point_spread_px, 0.6, 0.05);
  EXPECT_NEAR(quality.sharpening, 0.8, 0.15);
  EXPECT_TRUE(quality.jpeg_blocks);
  EXPECT_TRUE(quality.shared_chroma);
  EXPECT_NEAR(std::sqrt(quality.full_scale_electrons / kFullWell), 1.0, 0.25);
  EXPECT_TRUE(std::filesystem::exists(folder / "calibration.scene-focus.png"));

  const auto blank =
      run_kasumi(fmt::format("calibrate focus {} --box 0,0,12,12 --out {}", folder.string(), out.string()));
  EXPECT_EQ(blank.code, 2);
  EXPECT_THAT(blank.err, testing::HasSubstr("expected 5 or more"));
}

}  // namespace
}  // namespace kasumi
