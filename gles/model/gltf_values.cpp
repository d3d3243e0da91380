#include "gles/model/gltf_values.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

std::vector<double> numbers(const tinygltf::Value& object, const std::string& key, std::vector<double> fallback) {
  if (!object.IsObject() || !object.Has(key)) return fallback;
  const tinygltf::Value& value = object.Get(key);
  std::vector<double> read;
  if (value.IsNumber()) read.push_back(value.GetNumberAsDouble());
  if (value.IsArray())
    for (std::size_t i = 0; i < value.ArrayLen(); ++i) {
      const tinygltf::Value& element = value.Get(static_cast<int>(i));
      if (element.IsNumber()) read.push_back(element.GetNumberAsDouble());
    }
  const bool usable =
      read.size() == fallback.size() && std::ranges::all_of(read, [](double v) { return std::isfinite(v); });
  return usable ? read : fallback;
}

int whole_number(const tinygltf::Value& object, const std::string& key, int fallback, int most) {
  return static_cast<int>(std::clamp(numbers(object, key, {double(fallback)}).front(), -1.0, double(most)));
}

std::string text(const tinygltf::Value& object, const std::string& key) {
  if (!object.IsObject() || !object.Has(key) || !object.Get(key).IsString()) return {};
  return object.Get(key).Get<std::string>();
}

const tinygltf::Value* extension_of(const tinygltf::ExtensionMap& extensions, const std::string& name) {
  const auto found = extensions.find(name);
  return found == extensions.end() ? nullptr : &found->second;
}

void add_note(std::vector<std::string>& notes, std::string text) {
  constexpr std::size_t kMost = 100, kLongest = 1000;
  if (notes.size() > kMost || std::ranges::find(notes, text) != notes.end()) return;
  if (text.size() > kLongest) {
    std::size_t end = kLongest;
    while (end > 0 && (text[end] & 0xc0) == 0x80) --end;  // not within a letter of UTF-8
    text = text.substr(0, end) + " ...";
  }
  notes.push_back(notes.size() < kMost ? std::move(text) : "and more of its kind, which is not listed");
}

}  // namespace kasumi
