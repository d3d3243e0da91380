// Leaves before the building: the pixels that the mask leaves open, against a reference on the CPU and against twins in
// which the leaves' coverage is known.
#include <algorithm>
#include <array>
#include <cmath>

#include "calib/mask/sway_mask.hpp"
#include "fixtures/in_front/leaves.hpp"
#include "fixtures/noise/random.hpp"
#include "gles/composite/matte_nodes.hpp"
#include "tests/figures.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 480, kHeight = 270;

// What the demo's camera sees, from this pixel on.
Image<Rgb8> land(int left, int top) {
  const auto path = source_folder() / "fixtures/demo/scene/frame-000000.jpg";
  const cv::Mat picture = cv::imread(path.string());
  if (picture.empty()) throw std::runtime_error("cannot read " + path.string());
  return rgb_of(picture(cv::Rect(left, top, kWidth, kHeight)));
}

std::vector<double> minutes() {
  std::vector<double> seconds;
  for (int i = 0; i < 60; ++i) seconds.push_back(0.37 * i);
  return seconds;
}

// Of the pixels that the mask leaves open and the building reaches, over a clip; steps of 255.
struct BandErrors {
  static constexpr int kPatch = 32;
  double sum = 0.0;
  int pixels = 0;
  Image<double> bias{kWidth / kPatch + 1, kHeight / kPatch + 1, 0.0}, count = bias;

  void add(int x, int y, Rgb8 is, Rgb8 should) {
    ++pixels;
    count.at(x / kPatch, y / kPatch) += 1.0;
    for (int c = 0; c < 3; ++c) {
      const double miss = double(is[c]) - should[c];
      sum += std::abs(miss) / 3.0;
      bias.at(x / kPatch, y / kPatch) += miss / 3.0;
    }
  }
  double mean_error() const { return sum / std::max(1, pixels); }
  // The brightest patch: too bright by so much in the mean over its pixels and the clip.
  double halo() const {
    double brightest = 0.0;
    for (std::size_t i = 0; i < bias.elements().size(); ++i)
      if (count.elements()[i] >= 40.0) brightest = std::max(brightest, bias.elements()[i] / count.elements()[i]);
    return brightest;
  }
};

// What is left to a matte that is told more than any can know, of the same pixels as BandErrors: why a goal is missed.
struct Oracles {
  BandErrors told_shares;  // what each pixel's leaves cover and what is behind them: the camera's rounding is left
  BandErrors filmed;       // the same of a camera with noise and JPEG, against what it would film of the truth
  BandErrors told_leaf;    // what is behind, and one light of the leaves for all of a patch: leaf differs from leaf
};

class MatteOfLeaves : public GlesTest {
 protected:
  // A wall of pale and dark squares with windows through which the land is seen, in the middle of the picture.
  static ReferenceScene scene() {
    ReferenceScene made;
    made.view = view_north(kWidth, kHeight, 2400);
    made.model = box_model(260, 170, 60, 6);
    ModelTexture texture = soft_texture(64);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        texture.pixels.at(x, y) =
            (x / 8 + y / 8) % 2 ? glm::u8vec4{200, 150, 120, 255} : glm::u8vec4{235, 225, 205, 255};
    made.model.textures.push_back(texture);
    made.model.materials[0].texture = static_cast<int>(made.model.textures.size()) - 1;
    made.model_to_world = model_to_world({0, 1500, -80, from_degrees(20), 1.0});
    made.appearance = afternoon(made.view);
    made.measured = measured_airlight(made.view);
    return made;
  }
  static fixtures::BoughSettings bough(double sway_px, std::uint64_t seed, double light) {
    return {.width = kWidth,
            .height = kHeight,
            .root_px = {-60, 60},
            .tip_px = {310, 180},
            .spread_px = 110,
            .leaves = 2400,
            .leaf_px = 10,
            .sway_px = sway_px,
            .light = glm::dvec3{light},
            .seed = seed};
  }

  static void save_grey(const Image<std::uint8_t>& picture, const std::filesystem::path& path) {
    Image<Rgb8> grey(picture.width(), picture.height());
    std::ranges::transform(picture.elements(), grey.elements().begin(), [](std::uint8_t value) { return Rgb8(value); });
    save_png(grey, path);
  }

  // As it was done before: in linear light by the mask alone.
  static Rgb8 mix(const ResponseCurve& response, Rgb8 camera, Rgb8 with, double share) {
    Rgb8 pixel;
    for (int c = 0; c < 3; ++c) {
      const double light = std::lerp(reference_light(response, c, camera[c] / 255.0),
                                     reference_light(response, c, with[c] / 255.0), share);
      pixel[c] = static_cast<std::uint8_t>(std::lround(255.0 * reference_code(response, c, light)));
    }
    return pixel;
  }

  // As a camera does it: encoded Y + amount (Y - its binomial mean over 3 x 3 pixels).
  static Image<Rgb8> sharpened(const Image<Rgb8>& picture, double amount) {
    const auto luma = [&](int x, int y) {
      return glm::dot(glm::dvec3(0.299, 0.587, 0.114),
                      glm::dvec3(picture.at(std::clamp(x, 0, kWidth - 1), std::clamp(y, 0, kHeight - 1))));
    };
    Image<Rgb8> sharp(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        double more = luma(x, y);
        for (int v = -1; v <= 1; ++v)
          for (int u = -1; u <= 1; ++u) more -= (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * luma(x + u, y + v);
        for (int c = 0; c < 3; ++c)
          sharp.at(x, y)[c] =
              static_cast<std::uint8_t>(std::lround(std::clamp(picture.at(x, y)[c] + amount * more, 0.0, 255.0)));
      }
    return sharp;
  }

  // By a lens, in linear light.
  static Image<Rgb8> blurred(const ResponseCurve& response, const Image<Rgb8>& picture, double sigma_px) {
    Image<Rgb8> soft(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        glm::dvec3 sum(0.0);
        double weights = 0.0;
        for (int v = -3; v <= 3; ++v)
          for (int u = -3; u <= 3; ++u) {
            const double weight = std::exp(-0.5 * (u * u + v * v) / (sigma_px * sigma_px));
            const auto& pixel = picture.at(std::clamp(x + u, 0, kWidth - 1), std::clamp(y + v, 0, kHeight - 1));
            for (int c = 0; c < 3; ++c) sum[c] += weight * reference_light(response, c, pixel[c] / 255.0);
            weights += weight;
          }
        for (int c = 0; c < 3; ++c)
          soft.at(x, y)[c] =
              static_cast<std::uint8_t>(std::lround(255.0 * reference_code(response, c, sum[c] / weights)));
      }
    return soft;
  }

  static glm::dvec3 light_of(const ResponseCurve& response, Rgb8 pixel) {
    glm::dvec3 light;
    for (int c = 0; c < 3; ++c) light[c] = reference_light(response, c, pixel[c] / 255.0);
    return light;
  }
  static Rgb8 pixel_of(const ResponseCurve& response, const glm::dvec3& light) {
    Rgb8 pixel;
    for (int c = 0; c < 3; ++c)
      pixel[c] = static_cast<std::uint8_t>(
          std::lround(255.0 * std::clamp(reference_code(response, c, std::clamp(light[c], 0.0, 1.0)), 0.0, 1.0)));
    return pixel;
  }

  // Sixty pictures with a camera's noise, while the light changes.
  static std::vector<Image<Rgb8>> a_minute(const Image<Rgb8>& back, const fixtures::Bough& bough) {
    fixtures::Random random(5);
    std::vector<Image<Rgb8>> film;
    for (int i = 0; i < 60; ++i) {
      film.push_back(fixtures::put_before(back, bough.at(0.2 + 1.03 * i)));
      const double exposure = 1.0 + 0.08 * std::sin(0.2 * i);
      for (Rgb8& pixel : film.back().elements())
        for (int c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>(
              std::lround(std::clamp(exposure * pixel[c] + 1.2 * random.normal(), 0.0, 255.0)));
    }
    return film;
  }

  // By a camera of usual noise that delivers JPEG.
  static Image<Rgb8> filmed(const Image<Rgb8>& picture, std::uint64_t seed) {
    constexpr double kNoise = 1.2;  // of 255
    constexpr int kQuality = 92;
    fixtures::Random random(seed);
    cv::Mat noisy(kHeight, kWidth, CV_8UC3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c)
          noisy.at<cv::Vec3b>(y, x)[2 - c] = static_cast<std::uint8_t>(
              std::lround(std::clamp(picture.at(x, y)[c] + kNoise * random.normal(), 0.0, 255.0)));
    return rgb_of(through_jpeg(noisy, kQuality));
  }

  static void ask_oracles(const ReferenceScene& scene, const Image<Rgb8>& back, const Image<Rgb8>& with,
                          const Image<glm::vec4>& leaves, std::uint64_t seed, Oracles& found) {
    const auto camera = fixtures::put_before(back, leaves), truth = fixtures::put_before(with, leaves);
    const auto film = filmed(camera, 2 * seed), film_of_truth = filmed(truth, 2 * seed + 1);
    constexpr int kPatch = BandErrors::kPatch;
    Image<glm::dvec4> leaf(kWidth / kPatch + 1, kHeight / kPatch + 1, glm::dvec4(0.0));
    const auto counts = [&](int x, int y) {
      const auto mask = scene.mask.at(x, y);
      return mask != 0 && mask != 255 && back.at(x, y) != with.at(x, y);
    };
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (counts(x, y)) leaf.at(x / kPatch, y / kPatch) += glm::dvec4(leaves.at(x, y));
    const glm::dvec3 luma{0.299, 0.587, 0.114};
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (!counts(x, y)) continue;
        const glm::dvec3 behind = light_of(scene.response, back.at(x, y)),
                         building = light_of(scene.response, with.at(x, y)),
                         now = light_of(scene.response, camera.at(x, y));
        const double open = 1.0 - double(leaves.at(x, y).a);
        const glm::dvec3 change = open * (building - behind);
        found.told_shares.add(x, y, pixel_of(scene.response, now + change), truth.at(x, y));
        found.filmed.add(x, y, pixel_of(scene.response, light_of(scene.response, film.at(x, y)) + change),
                         film_of_truth.at(x, y));
        const glm::dvec4 sum = leaf.at(x / kPatch, y / kPatch);
        const glm::dvec3 towards = glm::dvec3(sum) / std::max(sum.a, 1e-9) - behind;
        const double covered = std::clamp(
            glm::dot(luma * towards, now - behind) / std::max(glm::dot(luma * towards, towards), 1e-9), 0.0, 1.0);
        const glm::dvec3 seen = (1.0 - covered) * (building - behind);
        found.told_leaf.add(x, y, pixel_of(scene.response, now + seen), truth.at(x, y));
      }
  }

  // The picture with the leaves in it, as drawn and as it should be. `band`: a mask whose open pixels count, too.
  void compare(Renderer& renderer, const ReferenceScene& scene, const Image<Rgb8>& back, const Image<Rgb8>& with,
               const Image<glm::vec4>& leaves, BandErrors& found, BandErrors& mixed, const char* name = nullptr,
               double sharpening = 0.0, const Image<std::uint8_t>* band = nullptr) {
    const auto camera = sharpened(fixtures::put_before(back, leaves), sharpening);
    const auto truth = sharpened(fixtures::put_before(with, leaves), sharpening);
    const auto drawn = draw(renderer, scene.measured, view_of(camera));
    if (name)
      for (const auto& [what, picture] : {std::pair{"camera", &camera}, {"drawn", &drawn}, {"truth", &truth}})
        save_png(*picture, test_output_folder() / fmt::format("{}-{}.png", name, what));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const auto mask = scene.mask.at(x, y);
        const auto is_open = [](std::uint8_t share) { return share != 0 && share != 255; };
        const bool open = is_open(mask), building = back.at(x, y) != with.at(x, y);
        if (building && (open || (band && is_open(band->at(x, y))))) {
          found.add(x, y, drawn.at(x, y), truth.at(x, y));
          mixed.add(x, y, mix(scene.response, camera.at(x, y), with.at(x, y), mask / 255.0), truth.at(x, y));
        }
        // Bit for bit, where all is in front or no building is there.
        if (mask == 0 || (open && !building)) {
          ASSERT_EQ(drawn.at(x, y), camera.at(x, y)) << x << ", " << y;
        }
      }
  }
};

// matte.frag knows a pixel by its direction and its distance alone, also where a node lies beyond the picture.
TEST(MatteNodes, LookAlongEightDirectionsFromWithinThePicture) {
  constexpr std::array<glm::ivec2, kMatteDirections> kAround{
      {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
  Image<std::uint8_t> mask(61, 43, 255);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = (x + y) % 20 < 7 ? 0 : (x + y) % 20 < 12 ? 120 : 255;
  const MatteNodes nodes = matte_nodes(mask, {0, 0, mask.width(), mask.height()}, 1024, 1024);
  int beyond = 0, taps = 0;
  for (const MatteNode& node : nodes.nodes) {
    const glm::ivec2 from = first_looked_at(nodes, node.at, {mask.width(), mask.height()});
    ASSERT_TRUE(mask.contains(from.x, from.y));
    beyond += from != nodes.corner_px + nodes.cell_px * node.at + nodes.cell_px / 2;
    for (const auto* kind : {&node.clear, &node.front})
      for (std::size_t i = 0; i < kAround.size(); ++i) {
        if (!(*kind)[i]) continue;
        const glm::ivec2 way = *(*kind)[i] - from;
        ASSERT_EQ(way, std::max(std::abs(way.x), std::abs(way.y)) * kAround[i]);
        ++taps;
      }
  }
  EXPECT_GT(beyond, 0);
  EXPECT_GT(taps, 500);
}

TEST_F(MatteOfLeaves, IsTheCpusOnEveryPath) {
  ReferenceScene scene = MatteOfLeaves::scene();
  const fixtures::Bough bough(MatteOfLeaves::bough(6.0, 1, 1.0));
  scene.mask = fixtures::mask_of(bough, minutes());
  const auto camera = fixtures::put_before(land(420, 180), bough.at(1.3));
  const auto reference = render_reference(scene, camera, turned_lattice());
  for (const RendererOptions& options :
       {RendererOptions{}, RendererOptions{.force_rgba8 = true}, RendererOptions{.force_promised_units = true}}) {
    Renderer renderer = loaded(scene, options);
    const auto drawn = draw(renderer, scene.measured, view_of(camera));
    expect_like(drawn, reference, 47.0);
    int beyond = 0, open = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (scene.mask.at(x, y) == 0 || scene.mask.at(x, y) == 255 || reference.layer.at(x, y).a <= 0.0) continue;
        ++open;
        const glm::dvec3 miss = glm::abs(glm::dvec3(drawn.at(x, y)) - reference.encoded.at(x, y));
        if (std::max({miss.r, miss.g, miss.b}) > 2.0) ++beyond;
      }
    EXPECT_GT(open, 5000);
    EXPECT_LE(beyond, open / 100) << "of " << open;
  }
}

TEST_F(MatteOfLeaves, LooksAsIfTheBuildingStoodBehindThem) {
  struct Case {
    const char* what;
    double sway_px;
    double light;
    int left, top;
  };
  // Sky and hills behind; leaves in the sun and against the light.
  const std::vector<Case> cases{{"at rest", 0.0, 1.0, 420, 180},
                                {"at rest, dark", 0.0, 0.4, 420, 180},
                                {"swaying 3 px", 3.0, 1.0, 420, 180},
                                {"swaying 6 px", 6.0, 1.0, 420, 180},
                                {"swaying 6 px, dark", 6.0, 0.4, 420, 180},
                                {"swaying 6 px, low hills", 6.0, 1.0, 620, 120},
                                {"swaying 10 px", 10.0, 1.0, 420, 180}};
  for (const Case& a_case : figure_cases("leaves", {cases[1], cases[3]}, cases)) {
    ReferenceScene scene = MatteOfLeaves::scene();
    const fixtures::Bough bough(MatteOfLeaves::bough(a_case.sway_px, 3, a_case.light));
    const auto back = land(a_case.left, a_case.top);
    Renderer renderer = loaded(scene);
    const auto with = draw(renderer, scene.measured, view_of(back));
    scene.mask = fixtures::mask_of(bough, a_case.sway_px > 0.0 ? minutes() : std::vector<double>{0.0});
    load(renderer, scene);
    BandErrors found, mixed;
    Oracles oracles;
    const int frames = a_case.sway_px > 0.0 ? 6 : 1;
    for (int i = 0; i < frames; ++i) {
      const auto leaves = bough.at(0.61 * i);
      compare(renderer, scene, back, with, leaves, found, mixed, i == 0 ? a_case.what : nullptr);
      ask_oracles(scene, back, with, leaves, static_cast<std::uint64_t>(i) + 1, oracles);
    }
    fmt::print(
        "{}: {} pixels, mean error {:.2f}, halo {:.2f}; told shares and background {:.2f}, {:.2f} (filmed {:.2f}, "
        "{:.2f}); told background and a patch's leaf {:.2f}, {:.2f}\n",
        a_case.what, found.pixels, found.mean_error(), found.halo(), oracles.told_shares.mean_error(),
        oracles.told_shares.halo(), oracles.filmed.mean_error(), oracles.filmed.halo(), oracles.told_leaf.mean_error(),
        oracles.told_leaf.halo());
    figure_row("leaves",
               {a_case.what, figure_text(found.mean_error(), 1), figure_text(found.halo(), 1),
                figure_text(mixed.mean_error(), 0), figure_text(mixed.halo(), 0), figure_text(oracles.filmed.halo(), 1),
                figure_text(oracles.told_leaf.mean_error(), 1), figure_text(oracles.told_leaf.halo(), 1)});
    EXPECT_GT(found.pixels, 700);
    EXPECT_GE(mixed.mean_error(), 2.0 * found.mean_error()) << a_case.what;
    EXPECT_LE(found.mean_error(), 2.0) << a_case.what;
    EXPECT_LE(found.halo(), 2.1) << a_case.what;
  }
}

// Woods of the leaves' light: the less tells them apart, the more of the mask's share is taken, and never is the picture
// worse than by the mask alone. What `calibrate mask` proposes there is wrong, as docs/calibration.md says.
TEST_F(MatteOfLeaves, IsNoWorseThanTheMaskBeforeWoodsAsBright) {
  struct Case {
    const char* what;
    double light;
    int left, top;
  };
  const std::vector<Case> cases{{"darker than the woods", 1.0, 380, 300},
                                {"as bright as the woods", 1.7, 380, 300},
                                {"brighter than the woods", 3.0, 380, 300},
                                {"as bright as near trees", 0.8, 0, 450}};
  for (const Case& a_case : figure_cases("leaves-alike", {cases[3]}, cases)) {
    ReferenceScene scene = MatteOfLeaves::scene();
    const fixtures::Bough bough(MatteOfLeaves::bough(6.0, 3, a_case.light));
    const auto back = land(a_case.left, a_case.top);
    Renderer renderer = loaded(scene);
    const auto with = draw(renderer, scene.measured, view_of(back));
    const auto truth = fixtures::mask_of(bough, minutes());
    const auto errors_by = [&](const Image<std::uint8_t>& mask) {
      scene.mask = mask;
      load(renderer, scene);
      BandErrors found, mixed;
      for (int i = 0; i < 6; ++i)
        compare(renderer, scene, back, with, bough.at(0.61 * i), found, mixed, i == 0 ? a_case.what : nullptr, 0.0,
                &truth);
      return std::pair(found, mixed);
    };
    const auto [found, mixed] = errors_by(truth);
    EXPECT_GT(found.pixels, 700);
    EXPECT_LE(found.mean_error(), mixed.mean_error()) << a_case.what;
    const auto proposed = find_sway_mask(a_minute(back, bough), Response::srgb(), {});
    ASSERT_FALSE(proposed.mask.empty()) << a_case.what;
    const auto by_proposal = errors_by(proposed.mask).first;
    fmt::print("{}: {} pixels, mean error {:.2f}, halo {:.2f}; by the mask {:.2f}, {:.2f}; proposed {:.2f}, {:.2f}\n",
               a_case.what, found.pixels, found.mean_error(), found.halo(), mixed.mean_error(), mixed.halo(),
               by_proposal.mean_error(), by_proposal.halo());
    figure_row("leaves-alike", {a_case.what, figure_text(found.mean_error(), 1), figure_text(found.halo(), 1),
                                figure_text(mixed.mean_error(), 0), figure_text(mixed.halo(), 0),
                                figure_text(by_proposal.mean_error(), 0)});
  }
}

// The mask as `calibrate mask` finds it in a minute's pictures, with a camera's noise, while the light changes.
TEST_F(MatteOfLeaves, LooksSoByTheMaskThatARecordingProposes) {
  struct Case {
    const char* what;
    double sway_px;
    double light;
    int left, top;
  };
  const std::vector<Case> cases{{"proposed, swaying 3 px", 3.0, 1.0, 420, 180},
                                {"proposed, swaying 6 px", 6.0, 1.0, 420, 180},
                                {"proposed, swaying 6 px, dark", 6.0, 0.4, 420, 180},
                                {"proposed, swaying 6 px, low hills", 6.0, 1.0, 620, 120},
                                {"proposed, swaying 10 px", 10.0, 1.0, 420, 180}};
  for (const Case& a_case : figure_cases("leaves-proposed", {cases[1]}, cases)) {
    ReferenceScene scene = MatteOfLeaves::scene();
    const fixtures::Bough bough(MatteOfLeaves::bough(a_case.sway_px, 3, a_case.light));
    const auto back = land(a_case.left, a_case.top);
    Renderer renderer = loaded(scene);
    const auto with = draw(renderer, scene.measured, view_of(back));
    const auto truth = fixtures::mask_of(bough, minutes());
    const auto proposed = find_sway_mask(a_minute(back, bough), Response::srgb(), {});
    ASSERT_FALSE(proposed.mask.empty()) << a_case.what;
    save_grey(proposed.mask, test_output_folder() / fmt::format("{}-mask.png", a_case.what));
    save_grey(truth, test_output_folder() / fmt::format("{}-truth-mask.png", a_case.what));
    scene.mask = proposed.mask;
    load(renderer, scene);
    BandErrors found, mixed;
    for (int i = 0; i < 6; ++i)
      compare(renderer, scene, back, with, bough.at(0.61 * i), found, mixed, i == 0 ? a_case.what : nullptr, 0.0,
              &truth);
    fmt::print("{}: {} pixels, mean error {:.2f}, halo {:.2f}\n", a_case.what, found.pixels, found.mean_error(),
               found.halo());
    figure_row("leaves-proposed", {a_case.what, figure_text(found.mean_error(), 1), figure_text(found.halo(), 1)});
    EXPECT_GT(found.pixels, 700);
    EXPECT_LE(found.mean_error(), 2.0) << a_case.what;
    EXPECT_LE(found.halo(), 2.1) << a_case.what;
  }
}

TEST_F(MatteOfLeaves, LooksSoToACameraThatSharpens) {
  constexpr double kAmount = 0.9;
  for (const double sway_px : {0.0, 6.0})
    for (const RendererOptions& options : {RendererOptions{}, RendererOptions{.force_promised_units = true}}) {
      const std::string what = fmt::format("sharpened, swaying {} px{}", sway_px,
                                           options.force_promised_units ? ", eight texture units" : "");
      ReferenceScene scene = MatteOfLeaves::scene();
      const fixtures::Bough bough(MatteOfLeaves::bough(sway_px, 3, 1.0));
      const auto back = land(420, 180);
      Renderer renderer = loaded(scene, options);
      const auto with = draw(renderer, scene.measured, view_of(back));
      scene.mask = fixtures::mask_of(bough, sway_px > 0.0 ? minutes() : std::vector<double>{0.0});
      ASSERT_OK(renderer.set_detail({.sharpening = kAmount}));
      load(renderer, scene);
      BandErrors found, mixed;
      const int frames = sway_px > 0.0 ? 6 : 1;
      for (int i = 0; i < frames; ++i)
        compare(renderer, scene, back, with, bough.at(0.61 * i), found, mixed, i == 0 ? what.c_str() : nullptr,
                kAmount);
      fmt::print("{}: {} pixels, mean error {:.2f}, halo {:.2f}; by the mask {:.2f}, {:.2f}\n", what, found.pixels,
                 found.mean_error(), found.halo(), mixed.mean_error(), mixed.halo());
      EXPECT_GT(found.pixels, 700);
      EXPECT_GE(mixed.mean_error(), 2.0 * found.mean_error()) << what;
    }
}

// A mask is sharp, a camera's picture is not: an edge without its blur would be sharpened to a bright seam.
TEST_F(MatteOfLeaves, StillEdgesAreAsSoftAsTheirCamerasPicture) {
  constexpr double kAmount = 0.8, kSpread_px = 0.6;
  ReferenceScene scene = MatteOfLeaves::scene();
  const fixtures::Bough bough(MatteOfLeaves::bough(0.0, 3, 0.4));
  const auto back = land(420, 180);
  Renderer renderer = loaded(scene);
  const auto with = draw(renderer, scene.measured, view_of(back));
  const auto leaves = bough.at(0.0);
  const auto filmed = [&](const Image<Rgb8>& behind) {
    return sharpened(blurred(scene.response, fixtures::put_before(behind, leaves), kSpread_px), kAmount);
  };
  const auto camera = filmed(back), truth = filmed(with);
  scene.mask = fixtures::mask_of(bough, {0.0});
  ASSERT_OK(renderer.set_detail({.point_spread_px = kSpread_px, .sharpening = kAmount}));
  load(renderer, scene);
  const auto of_edges = [&](const char* what) {
    const auto drawn = draw(renderer, scene.measured, view_of(camera));
    save_png(drawn, test_output_folder() / fmt::format("soft-edges-{}.png", what));
    BandErrors band;
    for (int y = 2; y < kHeight - 2; ++y)
      for (int x = 2; x < kWidth - 2; ++x) {
        bool open = false;
        for (int v = -2; v <= 2; ++v)
          for (int u = -2; u <= 2; ++u) open = open || scene.mask.at(x + u, y + v) != scene.mask.at(x, y);
        if (!open || back.at(x, y) == with.at(x, y)) continue;
        band.add(x, y, drawn.at(x, y), truth.at(x, y));
      }
    fmt::print("edges {}: {} pixels, mean error {:.2f}, halo {:.2f}\n", what, band.pixels, band.mean_error(),
               band.halo());
    return band;
  };
  const auto sharp = of_edges("as the mask's");
  ASSERT_OK(renderer.set_foreground(scene.mask, kSpread_px));
  ASSERT_OK(renderer.redraw_layer(scene.appearance));
  const auto soft = of_edges("as the camera's");
  EXPECT_GT(soft.pixels, 3000);
  EXPECT_LE(soft.mean_error(), 0.5 * sharp.mean_error());
  EXPECT_LE(soft.halo(), 0.5 * sharp.halo());
}

TEST_F(MatteOfLeaves, FollowsALayerThatIsDrawnWithAnotherDetail) {
  ReferenceScene scene = MatteOfLeaves::scene();
  const fixtures::Bough bough(MatteOfLeaves::bough(6.0, 1, 1.0));
  scene.mask = fixtures::mask_of(bough, minutes());
  const auto camera = fixtures::put_before(land(420, 180), bough.at(1.3));
  const ObjectDetail hazy{.point_spread_px = 2.5};
  Renderer renderer = loaded(scene), fresh = make_renderer();
  const auto box = renderer.object_box();
  draw(renderer, scene.measured, view_of(camera));
  ASSERT_OK(renderer.begin_layer(scene.appearance, {.detail = hazy}));
  for (bool whole = false; !whole;) {
    const auto step = renderer.continue_layer([] { return false; });
    ASSERT_OK(step);
    whole = *step;
  }
  EXPECT_NE(renderer.object_box(), box);
  ASSERT_OK(fresh.set_detail(hazy));
  load(fresh, scene);
  EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(),
            draw(fresh, scene.measured, view_of(camera)).elements());
}

}  // namespace
}  // namespace kasumi
