// A scene camera's frames and the building drawn over them: what the tests of the compositor share.
#pragma once

#include <filesystem>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/frame.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "tests/gles/picture/lent_buffers.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {

class Compositors : public testing::Test {
 protected:
  static constexpr int kWidth = 480, kHeight = 270;

  static void SetUpTestSuite() { folder_ = new std::filesystem::path(recorded(small("clear-noon", 1), "compositor")); }
  static void TearDownTestSuite() { delete folder_; }

  void SetUp() override {
    auto context = open_headless_context();
    if (!context) GTEST_SKIP() << context.error().message;
    context_ = std::move(*context);
    play(*folder_);
    report_.sun = {SunSource::ephemeris, SunDirection{0.0, -0.6, 0.8}, std::nullopt, false, {}};
    report_.estimate.sky = SkyCondition::clear;
  }

  void play(const std::filesystem::path& recording) {
    installation_ = must(read_fixture(recording))->installation;
    model_ = *must(read_gltf(installation_.object.model));
  }
  Compositor make(const RendererOptions& options = {}) {
    return std::move(*must(Compositor::create(*context_, installation_, model_, SceneAir(installation_, {}), options)));
  }
  RendererOptions with_test_images() {
    RendererOptions options;
    options.import_on_software = true;
    options.image_device = [this](const GlInfo&) -> Result<std::unique_ptr<ImageDevice>> {
      return std::make_unique<TestImages>(calls_);
    };
    return options;
  }

  // A frame in a driver's buffer; `returned` becomes true when the driver gets it back.
  static Frame lent(const Buffer& buffer, bool& returned) {
    returned = false;
    Frame frame;
    frame.metadata.format = four_cc("NV12");
    frame.metadata.width = kWidth;
    frame.metadata.height = kHeight;
    frame.metadata.stride = buffer.picture.planes[0].stride;
    frame.metadata.bytes_used = static_cast<std::uint32_t>(buffer.bytes());
    frame.payload.bytes = {buffer.view.planes[0].data, buffer.bytes()};
    frame.payload.dma_buf = DmaBuf{buffer.fd(), 0, buffer.picture.buffer};
    frame.payload.holder = std::shared_ptr<const void>(&buffer, [&returned](const void*) { returned = true; });
    return frame;
  }
  static Frame copied(Frame frame) {
    frame.payload = payload_of({frame.payload.bytes.begin(), frame.payload.bytes.end()});
    return frame;
  }

  template <class Draw>
  Image<Rgb8> picture_of(Draw draw) {
    auto target = Offscreen::create(context_->info(), kWidth, kHeight);
    EXPECT_TRUE(target.has_value());
    const auto drawn = draw(target->target());
    EXPECT_TRUE(drawn.has_value()) << (drawn ? "" : drawn.error().message);
    return target->read().value();
  }
  Image<Rgb8> drawn(Compositor& compositor, const Frame& frame) {
    return picture_of([&](const DrawTarget& target) { return compositor.draw(frame, report_, target); });
  }
  Image<Rgb8> drawn_again(Compositor& compositor) {
    return picture_of([&](const DrawTarget& target) { return compositor.draw_again(target); });
  }

  static inline const std::filesystem::path* folder_ = nullptr;
  ImageCalls calls_;
  std::unique_ptr<GlContext> context_;
  Installation installation_;
  Model model_;
  SkyReport report_;
};

}  // namespace kasumi
