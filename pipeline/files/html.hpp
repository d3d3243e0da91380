// Text and pictures embedded in a self-contained page.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace kasumi {

// For content and double-quoted attributes. Control characters, which HTML cannot represent, become U+FFFD.
std::string html_escaped(std::string_view text);

// RFC 2397, base64 (RFC 4648): "data:image/png;base64,...".
std::string data_uri(std::string_view media_type, std::span<const std::uint8_t> bytes);

}  // namespace kasumi
