#include "gles/air/haze_blur.hpp"

#include <algorithm>
#include <cmath>

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

enum Unit : int { kLight = 0, kLight2 = 1, kAlongRow = 2, kDownColumn = 3 };

void bind(int unit, const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.name());
}

// As in packed.glsl ("packed" is a reserved word in GLSL).
glm::u8vec4 packed(double first, double second) {
  const auto whole = [](double value) {
    return static_cast<unsigned>(std::lround(65535.0 * std::clamp(value, 0.0, 1.0)));
  };
  const unsigned a = whole(first), b = whole(second);
  return {a >> 8U, a & 255U, b >> 8U, b & 255U};
}
double unpacked(std::uint8_t high, std::uint8_t low) {
  return (256.0 * high + low) / 65535.0;
}

template <class First, class Second>
GlTexture packed_texture(int width, int height, First first, Second second) {
  Image<glm::u8vec4> texels(width, height);
  for (std::size_t i = 0; i < texels.elements().size(); ++i) texels.elements()[i] = packed(first(i), second(i));
  GlTexture texture = make_texture();
  bind(kLight, texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels.elements().data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

Result<> add(std::vector<Program>& programs, const Defines& defines, std::string_view fragment) {
  auto made = Program::build(defines, "square.vert", fragment);
  if (!made) return fail(made.error());
  programs.push_back(std::move(*made));
  return {};
}

}  // namespace

Result<HazeBlur::State> HazeBlur::make_state(const GlInfo& info) const {
  State state;
  for (int i = 0; i < (in_bytes_ ? 2 : 1); ++i) {
    auto buffer = LayerBuffer::create(width_, height_, in_bytes_, info, "a buffer for haze");
    if (!buffer) return fail(buffer.error());
    state.buffers.push_back(std::move(*buffer));
  }
  return state;
}

Result<HazeBlur> HazeBlur::create(const GlInfo& info, int width, int height, const BlurStorage& options) {
  if (width < 1 || height < 1 || width > info.max_texture_size || height > info.max_texture_size)
    return fail(FaultKind::bad_input, "a picture of {} x {} pixels: expected 1 .. {} each way on this driver", width,
                height, info.max_texture_size);
  if (!info.highp_fragments)
    return fail(FaultKind::unsupported,
                "{}: fragment shaders have only medium precision, too little for haze that blurs", info.renderer);
  HazeBlur made;
  made.width_ = width;
  made.height_ = height;
  const bool half_floats = info.has("GL_EXT_color_buffer_half_float") || info.has("GL_EXT_color_buffer_float");
  made.in_bytes_ = options.force_bytes || !half_floats;
  made.filters_ = !made.in_bytes_ && (info.es_major >= 3 || info.has("GL_OES_texture_half_float_linear"));

  const Defines pairs = made.in_bytes_ ? Defines{"IN_PAIRS"} : Defines{};
  Defines explicit_defines = pairs;
  explicit_defines.insert("MEAN_RATES");
  for (const char* which : {"FIRST_PAIR", "SECOND_PAIR"}) {
    if (auto done = add(made.begin_, made.in_bytes_ ? Defines{which} : Defines{}, "haze_begin.frag"); !done)
      return fail(done.error());
    if (!made.in_bytes_) break;
  }
  if (auto done = add(made.pass_, pairs, "haze_pass.frag"); !done) return fail(done.error());
  if (auto done = add(made.explicit_pass_, explicit_defines, "haze_pass.frag"); !done) return fail(done.error());
  if (auto done = add(made.end_, pairs, "haze_end.frag"); !done) return fail(done.error());
  for (State* state : {&made.now_, &made.next_}) {
    auto buffers = made.make_state(info);
    if (!buffers) return fail(buffers.error());
    *state = std::move(*buffers);
  }
  if (auto done = check_gl("creating the haze blur"); !done) return fail(done.error());
  return made;
}

Result<> HazeBlur::set_scene(const BlurInput& scene) {
  Problems problems;
  const auto fits = [&](const auto& image, const char* what) {
    if (image.width() != width_ || image.height() != height_)
      problems.add("{} of {} x {} pixels: expected {} x {}", what, image.width(), image.height(), width_, height_);
  };
  fits(scene.light, "light");
  fits(scene.range, "ranges");
  fits(scene.steps_along_row, "steps along rows");
  fits(scene.steps_down_column, "steps down columns");
  if (!problems.empty()) return fail(problems.fault());

  light_unit_ = 1.0;
  for (const auto& light : scene.light.elements())
    light_unit_ = std::max(
        {light_unit_, static_cast<double>(light.r), static_cast<double>(light.g), static_cast<double>(light.b)});
  range_scale_ = static_cast<double>(*std::ranges::max_element(scene.range.elements()));
  const auto channel = [&](int c) {
    return [&, c](std::size_t i) { return static_cast<double>(scene.light.elements()[i][c]) / light_unit_; };
  };
  const auto of = [](const Image<float>& image, double unit) {
    return [&image, unit](std::size_t i) { return static_cast<double>(image.elements()[i]) / unit; };
  };
  const auto nothing = [](std::size_t) { return 0.0; };
  red_green_ = packed_texture(width_, height_, channel(0), channel(1));
  blue_ = packed_texture(width_, height_, channel(2), nothing);
  along_row_ = packed_texture(width_, height_, of(scene.range, range_scale_), of(scene.steps_along_row, 1.0));
  down_column_ = packed_texture(width_, height_, of(scene.range, range_scale_), of(scene.steps_down_column, 1.0));
  has_scene_ = true;
  return check_gl("uploading a picture for haze");
}

void HazeBlur::draw_into(const LayerBuffer& buffer) const {
  glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
  glViewport(0, 0, width_, height_);
  draw_square();
}

Result<> HazeBlur::run(const HazeLook& look) {
  if (!has_scene_) return fail(FaultKind::bad_input, "no picture has been set to add haze to");
  for (const auto& pass : look.passes)
    if (pass.offset_px > std::min(width_, height_))
      return fail(FaultKind::bad_input, "haze needs steps of {:.0f} pixels: the picture has {} x {}", pass.offset_px,
                  width_, height_);
  look_ = look;
  unit_ = std::max({light_unit_, look.airlight.r, look.airlight.g, look.airlight.b});
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  const glm::dvec2 texel{1.0 / width_, 1.0 / height_};
  bind(kLight, red_green_);
  bind(kLight2, blue_);
  bind(kAlongRow, along_row_);
  bind(kDownColumn, down_column_);
  for (std::size_t i = 0; i < begin_.size(); ++i) {
    const Program& program = begin_[i];
    program.use();
    program.set("red_green", kLight);
    program.set("blue", kLight2);
    program.set("along_row", kAlongRow);
    program.set("texel", texel);
    program.set("range_scale", range_scale_);
    program.set("weight", std::span<const glm::dvec3>(look.weight));
    program.set("extinction", std::span<const glm::dvec3>(look.extinction));
    program.set("airlight", look.airlight);
    // The picture is stored in its own unit; the remaining light fits the larger one.
    program.set("light_unit", light_unit_);
    program.set("unit", unit_);
    draw_into(now_.buffers[i]);
  }
  const Program& program = look.explicit_passes > 0 ? explicit_pass_.front() : pass_.front();
  program.use();
  program.set("light", kLight);
  program.set("along_row", kAlongRow);
  program.set("down_column", kDownColumn);
  program.set("texel", texel);
  program.set("range_scale", range_scale_);
  program.set("inner", look.inner_px);
  program.set("widening", look.widening_px);
  program.set("surfaces", glm::dvec2{look.same_surface, look.other_surface});
  const auto pass = [&](const HazePass& given, double per_variance) {
    program.set("offset", given.offset_px);
    program.set("variance", glm::dvec2{given.from_px2, given.variance_px2});
    program.set("per_variance", per_variance);
    for (std::size_t i = 0; i < now_.buffers.size(); ++i) {
      bind(kLight, now_.buffers[i].texture);
      draw_into(next_.buffers[i]);
    }
    std::swap(now_, next_);
  };
  if (look.explicit_passes > 0)
    for (int k = 0; k < look.explicit_passes; ++k) pass({}, 0.5 / look.explicit_passes);
  else
    for (const auto& given : look.passes) pass(given, 0.5 / (given.offset_px * given.offset_px));
  return check_gl("blurring haze");
}

Result<> HazeBlur::show(const DrawTarget& target) const {
  const auto shown = letterbox(target, width_, height_);
  if (shown.width < 1 || shown.height < 1)
    return fail(FaultKind::bad_input, "a target of {} x {} pixels: expected at least 1 x 1", target.width,
                target.height);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, target.width, target.height);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glViewport(shown.x, shown.y, shown.width, shown.height);
  const Program& program = end_.front();
  program.use();
  bind(kLight, now_.buffers.front().texture);
  const bool smooth = filters_ && (shown.width != width_ || shown.height != height_);
  set_filter(smooth ? TextureFilter::linear : TextureFilter::nearest);
  if (in_bytes_) bind(kLight2, now_.buffers.back().texture);
  program.set("light", kLight);
  program.set("light_2", kLight2);
  program.set("airlight", look_.airlight);
  program.set("unit", unit_);
  program.set("box", glm::dvec4(shown.x, shown.y, 1.0 / shown.width, 1.0 / shown.height));
  program.set("bottom_first", target.top_row_first ? 0.0 : 1.0);
  draw_square();
  bind(kLight, now_.buffers.front().texture);
  set_filter(TextureFilter::nearest);
  return check_gl("showing haze");
}

Result<Image<glm::vec4>> HazeBlur::read() const {
  Image<glm::vec4> light(width_, height_);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  if (!in_bytes_) {
    glBindFramebuffer(GL_FRAMEBUFFER, now_.buffers.front().framebuffer.name());
    glReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, light.elements().data());
  }
  for (std::size_t pair = 0; in_bytes_ && pair < now_.buffers.size(); ++pair) {
    Image<glm::u8vec4> bytes(width_, height_);
    glBindFramebuffer(GL_FRAMEBUFFER, now_.buffers[pair].framebuffer.name());
    glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, bytes.elements().data());
    for (std::size_t i = 0; i < bytes.elements().size(); ++i) {
      const glm::u8vec4 texel = bytes.elements()[i];
      const auto first = static_cast<glm::length_t>(2 * pair);
      light.elements()[i][first] = static_cast<float>(unit_ * unpacked(texel.r, texel.g));
      light.elements()[i][first + 1] = static_cast<float>(unit_ * unpacked(texel.b, texel.a));
    }
  }
  if (auto done = check_gl("reading haze back"); !done) return fail(done.error());
  return light;
}

}  // namespace kasumi
