#include "report/web/pull_answer.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "report/web/web_request.hpp"

namespace kasumi::report {

namespace {

constexpr std::size_t kLongestTag = 200;  // of ETags: far above what servers send

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return number;
}

bool is_named(std::string_view name, std::string_view lower) {
  return std::ranges::equal(name, lower, [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; });
}

bool is_tag(std::string_view tag) {
  if (tag.size() > kLongestTag) return false;
  if (tag.starts_with("W/")) tag.remove_prefix(2);
  if (tag.size() < 2 || tag.front() != '"' || tag.back() != '"') return false;
  return std::ranges::all_of(tag.substr(1, tag.size() - 2), [](char c) { return c > 0x20 && c < 0x7f && c != '"'; });
}

// "bytes 100-199/200"
void take_range(std::string_view value, PullAnswer& answer) {
  answer.first.reset();
  answer.of_bytes.reset();
  if (!value.starts_with("bytes ")) return;
  value = trimmed(value.substr(6));
  const auto dash = value.find('-'), slash = value.find('/');
  if (dash == std::string_view::npos || slash == std::string_view::npos || dash > slash) return;
  const auto first = number_in(value.substr(0, dash)), last = number_in(value.substr(dash + 1, slash - dash - 1)),
             all = number_in(value.substr(slash + 1));
  // To its end, or it is not what was asked for.
  if (!first || !last || !all || *all == 0 || *first > *last || *last != *all - 1) return;
  answer.first = first;
  answer.of_bytes = all;
}

}  // namespace

void take_header(std::string_view line, PullAnswer& answer) {
  line = trimmed(line);
  if (line.starts_with("HTTP/")) {
    answer = {};
    const auto space = line.find(' ');
    if (space == std::string_view::npos) return;
    const auto code = number_in(line.substr(space + 1, 3));
    if (code && *code >= 100) answer.code = static_cast<int>(*code);
    return;
  }
  const auto colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const auto name = line.substr(0, colon), value = trimmed(line.substr(colon + 1));
  if (is_named(name, "etag")) answer.tag = is_tag(value) ? std::string(value) : std::string();
  if (is_named(name, "content-length")) answer.bytes = number_in(value);
  if (is_named(name, "content-range")) take_range(value, answer);
}

bool is_strong(std::string_view tag) {
  return tag.starts_with('"');
}

std::string text_of(const PullNote& note) {
  return fmt::format("{}\n{}\n{}\n", note.url, note.tag, note.bytes);
}

std::optional<PullNote> parse_pull_note(std::string_view text) {
  PullNote note;
  const auto next = [&]() -> std::string_view {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) return {};
    const auto line = text.substr(0, end);
    text.remove_prefix(end + 1);
    return line;
  };
  note.url = next();
  note.tag = next();
  const auto bytes = number_in(next());
  if (!is_web_address(note.url) || !is_tag(note.tag) || !bytes || !text.empty()) return std::nullopt;
  note.bytes = *bytes;
  return note;
}

}  // namespace kasumi::report
