// Generated recordings for the end-to-end tests, each made once (tests/made_once.hpp) and copied for each test.
#pragma once

#include <filesystem>
#include <string>

#include "fixtures/generator/generator.hpp"

namespace kasumi {

// For the output of the tests of this program.
std::filesystem::path test_folder(const std::string& name);

// A copy of the recipe's fixture in a folder of its own, which the test may change.
std::filesystem::path recorded(const fixtures::Recipe& recipe, const std::string& name);

// All that a recipe says, as text: two recipes of the same text make the same fixture.
std::string text_of(const fixtures::Recipe& recipe);

// A preset made small enough for a test: `frames` sky and scene frames.
fixtures::Recipe small(std::string_view preset, int frames);

// The same for a test that does not need the scene, which takes most of the time to draw.
fixtures::Recipe small_scene(std::string_view preset, int frames);

}  // namespace kasumi
