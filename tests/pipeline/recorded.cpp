#include "tests/pipeline/recorded.hpp"

#include <optional>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "tests/made_once.hpp"
#include "tests/places.hpp"

namespace kasumi {

namespace {

// Structured bindings name every field: a type that gets another no longer compiles here.
class RecipeText {
 public:
  template <class... Values>
  void put(const Values&... values) {
    (put_one(values), ...);
  }
  const std::string& text() const { return text_; }

 private:
  void put_one(double value) { text_ += fmt::format("{:a} ", value); }
  void put_one(const std::string& value) { text_ += fmt::format("{}:{} ", value.size(), value); }
  template <class Number>
  requires std::is_integral_v<Number>
  void put_one(Number value) { text_ += fmt::format("{} ", value); }
  template <class Choice>
  requires std::is_enum_v<Choice>
  void put_one(Choice value) { text_ += fmt::format("{} ", static_cast<int>(value)); }
  template <class Value>
  void put_one(const std::optional<Value>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class Value>
  void put_one(const std::vector<Value>& values) {
    put(values.size());
    for (const auto& value : values) put(value);
  }
  void put_one(Utc value) { put(value.time_since_epoch().count()); }
  // Its contents: the file may change under its name.
  void put_one(const std::filesystem::path& file) {
    put(file.string());
    if (!file.empty()) put(read_text_file(file).value_or(""));
  }
  void put_one(const Site& site) {
    const auto& [name, latitude, longitude, altitude] = site;
    put(name, latitude, longitude, altitude);
  }
  void put_one(const Aerosol& aerosol) {
    const auto& [depth, exponent, kind, other, share] = aerosol;
    put(depth, exponent, kind, other, share);
  }
  void put_one(const ImageQuality& quality) {
    const auto& [spread, full_scale, read, chroma, sharpening, saturation, blocks] = quality;
    put(spread, full_scale, read, chroma, sharpening, blocks);
    if (saturation) put(*saturation);
  }
  void put_one(const fixtures::Sharpness& sharpness) {
    const auto& [spread, sharpening] = sharpness;
    put(spread, sharpening);
  }
  void put_one(const fixtures::Outlook& outlook) {
    const auto& [heading, distance, ground, field, pitch] = outlook;
    put(heading, distance, ground, field, pitch);
  }
  void put_one(const fixtures::Hill& hill) {
    const auto& [azimuth, distance, height, uneven, over] = hill;
    put(azimuth, distance, height, uneven, over);
  }
  void put_one(const fixtures::FogLayer& fog) {
    const auto& [extinction, base, scale] = fog;
    put(extinction, base, scale);
  }
  void put_one(const fixtures::Passersby& who) {
    const auto& [people, flocks, cars, person, from] = who;
    put(people, flocks, cars, person, from);
  }

  std::string text_;
};

}  // namespace

std::string text_of(const fixtures::Recipe& recipe) {
  const auto& [name, description, seed, start, site, world, turbidity, turbidity_end, aerosol, cloud_cover, sky_kind,
               sky_frames, sky_period, times, sky_size, sky_format, scene_frames, scene_period, scene_width,
               scene_height, scene_format, jpeg_quality, tone_curve, sharpness, quality, outlook, hill, canopies, fog,
               building, model, leaves, passersby, landmarks, filmed_truth, truth_frames, noise, faults] = recipe;
  RecipeText text;
  text.put(name, description, seed, start, site, world, turbidity, turbidity_end, aerosol, cloud_cover, sky_kind,
           sky_frames, sky_period, times, sky_size, sky_format, scene_frames, scene_period, scene_width, scene_height,
           scene_format, jpeg_quality, tone_curve, sharpness, quality, outlook, hill, canopies, fog, building, model,
           leaves, passersby, landmarks, filmed_truth, truth_frames, noise, faults);
  return text.text();
}

std::filesystem::path test_folder(const std::string& name) {
  const auto path = test_output_folder() / "pipeline" / name;
  std::filesystem::create_directories(path.parent_path());
  return path;
}

std::filesystem::path recorded(const fixtures::Recipe& recipe, const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  const auto made = made_once(recipe.name, text_of(recipe), [&](const std::filesystem::path& unfinished) {
    const auto generated = fixtures::generate(recipe, unfinished);
    if (!generated) ADD_FAILURE() << generated.error().message;
    return generated.has_value();
  });
  if (!made.empty()) std::filesystem::copy(made, folder, std::filesystem::copy_options::recursive);
  return folder;
}

fixtures::Recipe small(std::string_view preset, int frames) {
  auto recipe = fixtures::recipe_of(preset).value();
  recipe.sky_frames = frames;
  recipe.scene_frames = frames;
  recipe.scene_width = 480;
  recipe.scene_height = 270;
  recipe.truth_frames = 0;
  return recipe;
}

fixtures::Recipe small_scene(std::string_view preset, int frames) {
  auto recipe = small(preset, frames);
  recipe.scene_width = 160;
  recipe.scene_height = 90;
  return recipe;
}

}  // namespace kasumi
