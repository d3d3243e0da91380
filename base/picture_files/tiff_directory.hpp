// A directory of a TIFF, which EXIF is as well (TIFF 6.0, section 2): tags and what they hold.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kasumi {

struct TiffEntry {
  std::uint16_t tag = 0, type = 0;
  std::uint32_t count = 0;
  std::vector<std::uint8_t> bytes;  // in the file's order
};

struct TiffStart {
  bool is_big_endian = false;
  std::size_t directory = 0;  // where the first one stands
};

// The number of 1 to 4 bytes; 0 beyond the end.
std::uint32_t tiff_number(std::span<const std::uint8_t> bytes, std::size_t at, int count, bool is_big_endian);
// What a SHORT or LONG holds first; 0: another type.
std::uint32_t first_number(const TiffEntry& entry, bool is_big_endian);

// Empty: no TIFF, or a BigTIFF.
std::optional<TiffStart> tiff_start(std::span<const std::uint8_t> file);
// Entries whose values lie outside the file are left out.
std::vector<TiffEntry> read_tiff_directory(std::span<const std::uint8_t> file, std::size_t at, bool is_big_endian);
// Null: there is none.
const TiffEntry* find_entry(const std::vector<TiffEntry>& entries, std::uint16_t tag);
TiffEntry long_entry(std::uint16_t tag, std::uint32_t value, bool is_big_endian);
// Sorted by tag, at the end of `file`, with no directory after it; returns where it stands.
std::size_t append_tiff_directory(std::vector<std::uint8_t>& file, std::vector<TiffEntry> entries, bool is_big_endian);
// Makes it the file's first.
void set_first_directory(std::vector<std::uint8_t>& file, std::size_t directory, bool is_big_endian);

// EXIF's tags of where and when: its own directory and GPS's.
constexpr std::uint16_t kExifDirectory = 0x8769, kGpsDirectory = 0x8825;
// Appends copies of those that `from` has in `entries` to `file`, whose order of bytes is the same; returns the entries
// that point at them. Makers' notes stay behind: they hold places in the file they were in.
std::vector<TiffEntry> copy_exif(std::span<const std::uint8_t> from, const std::vector<TiffEntry>& entries,
                                 std::vector<std::uint8_t>& file, bool is_big_endian);

}  // namespace kasumi
