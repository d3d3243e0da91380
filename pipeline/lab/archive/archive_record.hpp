// A record of an archive: the answer of `kasumi estimate --json` with the picture's time, why it was refused, and which
// picture of which list it is, so that a merge can prove that every picture is there exactly once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

// FNV-1a, 64 bits: tells lists and options apart; no protection against intent.
class Fingerprint {
 public:
  void add(std::string_view text);
  std::string text() const;  // 16 hexadecimal digits

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

// What all records of one archive share.
struct Archive {
  std::size_t pictures = 0;  // in the whole list
  std::string list;          // fingerprint of their names and times, in order
  std::string options;       // fingerprint of what answers depend on beside the picture
  bool operator==(const Archive&) const = default;
};

struct ArchivePlace {
  std::size_t picture = 0;  // from 1
  Archive archive;
};

// One line with its newline. `answer`: an object of --json. `refused`: in few words; empty: the air is known.
std::string archive_record(std::string_view answer, const std::optional<Utc>& utc, std::string_view refused,
                           const ArchivePlace& place);
// Of a picture that could not be read.
std::string unread_record(const std::string& image, const std::optional<Utc>& utc, const std::string& reason,
                          const ArchivePlace& place);
// Of a picture that is an exposure of a stack; `whole`: the picture whose record has the stack's answer.
constexpr std::string_view kExposureOfStack = "exposure of a stack";
std::string exposure_record(const std::string& image, const std::optional<Utc>& utc, const std::string& whole,
                            const ArchivePlace& place);

// What such a line, without its newline, ends with; empty: it is no whole record.
std::optional<ArchivePlace> place_in(std::string_view line);

}  // namespace kasumi
