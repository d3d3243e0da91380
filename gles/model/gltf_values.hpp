// Numbers of a glTF's extensions, which tinygltf passes on as they stand. For this room's glTF sources only.
#pragma once

#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace kasumi {

// One number or an array of as many finite ones as `fallback` has; anything else: `fallback`.
std::vector<double> numbers(const tinygltf::Value& object, const std::string& key, std::vector<double> fallback);
// -1 .. most; anything else: `fallback`.
int whole_number(const tinygltf::Value& object, const std::string& key, int fallback, int most = 1'000'000);
// "": none, or no text.
std::string text(const tinygltf::Value& object, const std::string& key);
// Null: not there.
const tinygltf::Value* extension_of(const tinygltf::ExtensionMap& extensions, const std::string& name);

// Each text once, and no more of them than are read.
void add_note(std::vector<std::string>& notes, std::string text);

}  // namespace kasumi
