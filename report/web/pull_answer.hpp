// What a server answers about a file, by its header lines (RFC 9110), and what is remembered of it over restarts.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kasumi::report {

struct PullAnswer {
  int code = 0;                        // of the last status line; 0: there was none
  std::string tag;                     // ETag, such as "\"abc\"" or "W/\"abc\""; empty: none that is one
  std::optional<std::uint64_t> bytes;  // Content-Length
  std::optional<std::uint64_t> first;  // of a part: where it begins (Content-Range), and of how many bytes
  std::optional<std::uint64_t> of_bytes;
};
// Takes a header line into it; a new status line begins anew. What cannot be understood is left out.
void take_header(std::string_view line, PullAnswer& answer);

// A part of a file that has one of these may be continued: byte for byte the same is promised by it.
bool is_strong(std::string_view tag);

// Which file of which address, and how much of it is surely on the disk.
struct PullNote {
  std::string url, tag;
  std::uint64_t bytes = 0;
  friend bool operator==(const PullNote&, const PullNote&) = default;
};
std::string text_of(const PullNote& note);
// Empty: it is none.
std::optional<PullNote> parse_pull_note(std::string_view text);

}  // namespace kasumi::report
