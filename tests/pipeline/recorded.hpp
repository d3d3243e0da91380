// Generated recordings for the end-to-end tests, each made once per test run.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "fixtures/generator/generator.hpp"
#include "tests/places.hpp"

namespace kasumi {

inline std::filesystem::path test_folder(const std::string& name) {
  const auto path = test_output_folder() / "pipeline" / name;
  std::filesystem::create_directories(path.parent_path());
  return path;
}

// Writes the recipe's fixture into a folder of its own and returns it.
inline std::filesystem::path recorded(const fixtures::Recipe& recipe, const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  const auto made = fixtures::generate(recipe, folder);
  if (!made) ADD_FAILURE() << made.error().message;
  return folder;
}

// A preset made small enough for a test: `frames` sky and scene frames.
inline fixtures::Recipe small(std::string_view preset, int frames) {
  auto recipe = fixtures::recipe_of(preset).value();
  recipe.sky_frames = frames;
  recipe.scene_frames = frames;
  recipe.scene_width = 480;
  recipe.scene_height = 270;
  recipe.truth_frames = 0;
  return recipe;
}

// The same for a test that does not need the scene, which takes most of the time to draw.
inline fixtures::Recipe small_scene(std::string_view preset, int frames) {
  auto recipe = small(preset, frames);
  recipe.scene_width = 160;
  recipe.scene_height = 90;
  return recipe;
}

}  // namespace kasumi
