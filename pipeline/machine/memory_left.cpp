#include "pipeline/machine/memory_left.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "base/files.hpp"

namespace kasumi {

namespace {

// The number that the text begins with, after blanks.
std::optional<std::uint64_t> leading_number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  std::uint64_t number = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), number).ec != std::errc()) return std::nullopt;
  return number;
}

std::optional<std::uint64_t> number_in(const std::filesystem::path& file, std::string_view after) {
  const auto text = read_text_file(file);
  if (!text) return std::nullopt;
  const auto at = text->find(after);
  return at == std::string::npos ? std::nullopt : leading_number(std::string_view(*text).substr(at + after.size()));
}

// Of the innermost group, "0::/system.slice/kasumi.service".
std::optional<std::uint64_t> left_in_group(const std::filesystem::path& proc, const std::filesystem::path& cgroups) {
  const auto groups = read_text_file(proc / "self" / "cgroup");
  if (!groups) return std::nullopt;
  const auto at = groups->find("0::/");
  if (at == std::string::npos) return std::nullopt;
  const auto folder = cgroups / groups->substr(at + 4, groups->find('\n', at) - at - 4);
  const auto most = number_in(folder / "memory.max", ""), used = number_in(folder / "memory.current", "");
  if (!most || !used) return std::nullopt;  // "max"
  // Files that were read are counted as used, and given up when memory is needed.
  const auto files = number_in(folder / "memory.stat", "\ninactive_file ").value_or(0);
  const auto held = *used - std::min(*used, files);
  return *most - std::min(*most, held);
}

}  // namespace

std::optional<std::uint64_t> memory_left(const std::filesystem::path& proc, const std::filesystem::path& cgroups) {
  const auto machine_kib = number_in(proc / "meminfo", "MemAvailable:");
  const auto group = left_in_group(proc, cgroups);
  if (!machine_kib) return group;
  return std::min(*machine_kib * 1024, group.value_or(*machine_kib * 1024));
}

}  // namespace kasumi
