// Several files in one input, so that a change in one can meet a change in another: "@@ NAME", a line break, its bytes,
// and so on. Only names a kiosk's folder may hold are written; tests/fuzz/pack makes such an input of a folder.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "tests/fuzz/scratch.hpp"
#include "tests/fuzz/small_picture.hpp"

namespace kasumi {

constexpr std::array<std::string_view, 7> kPackedNames{"kasumi.toml", "calibration.toml", "model.glb", "sky-mask.png",
                                                       "mask.png",    "depth.png",        "still.png"};

// Files that the input lacks are removed.
inline void unpack(std::span<const std::uint8_t> input, const Scratch& scratch) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::error_code error;
  for (const std::string_view name : kPackedNames) std::filesystem::remove(scratch.folder() / name, error);
  constexpr std::string_view kMark = "@@ ";
  for (std::size_t at = text.starts_with(kMark) ? 0 : std::string_view::npos; at != std::string_view::npos;) {
    const auto line_end = text.find('\n', at);
    if (line_end == std::string_view::npos) return;
    const auto name = text.substr(at + kMark.size(), line_end - at - kMark.size());
    auto next = text.find("\n@@ ", line_end);
    const auto end = next == std::string_view::npos ? text.size() : next;
    if (std::ranges::find(kPackedNames, name) != kPackedNames.end())
      if (const auto bytes = input.subspan(line_end + 1, end - line_end - 1); !holds_large_picture(bytes))
        scratch.file(std::string(name), bytes);
    at = next == std::string_view::npos ? next : next + 1;
  }
}

}  // namespace kasumi
