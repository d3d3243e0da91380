#include "base/picture_files/tiff_directory.hpp"

#include <algorithm>
#include <array>

namespace kasumi {

namespace {

constexpr std::size_t kEntryBytes = 12, kMostEntries = 1024;
constexpr std::uint16_t kShort = 3, kLong = 4, kMakerNote = 0x927c;

// Of one value, by type; 0: unknown.
std::size_t bytes_of(std::uint32_t type) {
  constexpr std::array<std::uint8_t, 14> kBytes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4};
  return type < kBytes.size() ? kBytes[type] : 0;
}

void put_number(std::vector<std::uint8_t>& file, std::size_t value, int bytes, bool is_big_endian) {
  for (int i = 0; i < bytes; ++i)
    file.push_back(static_cast<std::uint8_t>(value >> 8 * (is_big_endian ? bytes - 1 - i : i)));
}

}  // namespace

std::uint32_t tiff_number(std::span<const std::uint8_t> bytes, std::size_t at, int count, bool is_big_endian) {
  if (at > bytes.size() || bytes.size() - at < static_cast<std::size_t>(count)) return 0;
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i)
    value = value << 8 | bytes[at + static_cast<std::size_t>(is_big_endian ? i : count - 1 - i)];
  return value;
}

std::uint32_t first_number(const TiffEntry& entry, bool is_big_endian) {
  if (entry.type != kShort && entry.type != kLong) return 0;
  return tiff_number(entry.bytes, 0, entry.type == kShort ? 2 : 4, is_big_endian);
}

std::optional<TiffStart> tiff_start(std::span<const std::uint8_t> file) {
  if (file.size() < 8 || file[0] != file[1] || (file[0] != 'I' && file[0] != 'M')) return std::nullopt;
  const bool big = file[0] == 'M';
  if (tiff_number(file, 2, 2, big) != 42) return std::nullopt;
  return TiffStart{big, tiff_number(file, 4, 4, big)};
}

std::vector<TiffEntry> read_tiff_directory(std::span<const std::uint8_t> file, std::size_t at, bool is_big_endian) {
  std::vector<TiffEntry> entries;
  const std::size_t count = std::min<std::size_t>(tiff_number(file, at, 2, is_big_endian), kMostEntries);
  std::size_t left = file.size();  // of all values together: more would overlap
  for (std::size_t i = 0; i < count; ++i) {
    const auto entry = at + 2 + kEntryBytes * i;
    if (entry + kEntryBytes > file.size()) break;
    TiffEntry read{static_cast<std::uint16_t>(tiff_number(file, entry, 2, is_big_endian)),
                   static_cast<std::uint16_t>(tiff_number(file, entry + 2, 2, is_big_endian)),
                   tiff_number(file, entry + 4, 4, is_big_endian),
                   {}};
    const std::size_t bytes = bytes_of(read.type) * read.count;
    const std::size_t from = bytes <= 4 ? entry + 8 : tiff_number(file, entry + 8, 4, is_big_endian);
    if (bytes == 0 || bytes > left || from > file.size() || bytes > file.size() - from) continue;
    left -= bytes;
    const auto values = file.subspan(from, bytes);
    read.bytes.assign(values.begin(), values.end());
    entries.push_back(std::move(read));
  }
  return entries;
}

const TiffEntry* find_entry(const std::vector<TiffEntry>& entries, std::uint16_t tag) {
  const auto found = std::ranges::find(entries, tag, &TiffEntry::tag);
  return found == entries.end() ? nullptr : &*found;
}

TiffEntry long_entry(std::uint16_t tag, std::uint32_t value, bool is_big_endian) {
  TiffEntry entry{tag, kLong, 1, {}};
  put_number(entry.bytes, value, 4, is_big_endian);
  return entry;
}

std::size_t append_tiff_directory(std::vector<std::uint8_t>& file, std::vector<TiffEntry> entries, bool is_big_endian) {
  std::ranges::stable_sort(entries, {}, &TiffEntry::tag);
  const auto even = [&] {  // values and directories begin on a word boundary
    if (file.size() % 2 != 0) file.push_back(0);
  };
  for (auto& entry : entries) {
    if (entry.bytes.size() <= 4) {
      entry.bytes.resize(4);
      continue;
    }
    even();
    const auto at = file.size();
    file.insert(file.end(), entry.bytes.begin(), entry.bytes.end());
    entry.bytes.clear();
    put_number(entry.bytes, at, 4, is_big_endian);
  }
  even();
  const auto directory = file.size();
  put_number(file, entries.size(), 2, is_big_endian);
  for (const auto& entry : entries) {
    put_number(file, entry.tag, 2, is_big_endian);
    put_number(file, entry.type, 2, is_big_endian);
    put_number(file, entry.count, 4, is_big_endian);
    file.insert(file.end(), entry.bytes.begin(), entry.bytes.end());
  }
  put_number(file, 0, 4, is_big_endian);
  return directory;
}

void set_first_directory(std::vector<std::uint8_t>& file, std::size_t directory, bool is_big_endian) {
  std::vector<std::uint8_t> place;
  put_number(place, directory, 4, is_big_endian);
  std::ranges::copy(place, file.begin() + 4);
}

std::vector<TiffEntry> copy_exif(std::span<const std::uint8_t> from, const std::vector<TiffEntry>& entries,
                                 std::vector<std::uint8_t>& file, bool is_big_endian) {
  std::vector<TiffEntry> pointers;
  for (const auto tag : {kExifDirectory, kGpsDirectory}) {
    const auto* pointer = find_entry(entries, tag);
    if (!pointer) continue;
    auto directory = read_tiff_directory(from, first_number(*pointer, is_big_endian), is_big_endian);
    std::erase_if(directory, [](const TiffEntry& entry) { return entry.tag == kMakerNote; });
    if (directory.empty()) continue;
    const auto at = append_tiff_directory(file, std::move(directory), is_big_endian);
    pointers.push_back(long_entry(tag, static_cast<std::uint32_t>(at), is_big_endian));
  }
  return pointers;
}

}  // namespace kasumi
