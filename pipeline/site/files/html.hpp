// Text and pictures embedded in a self-contained page.
#pragma once

#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace kasumi {

// For content and double-quoted attributes. Control characters, which HTML cannot represent, become U+FFFD.
std::string html_escaped(std::string_view text);

// RFC 2397, base64 (RFC 4648): "data:image/png;base64,...".
std::string data_uri(std::string_view media_type, std::span<const std::uint8_t> bytes);

// The text of a page, put together from pieces with numbers in them.
class PageText {
 public:
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace kasumi
