// status.json, looked at again and again by a program that cannot rely on whoever writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "report/status/told_status.hpp"

namespace kasumi::report {

enum class Contact {
  heard,       // the appliance tells its status
  silent,      // it has not told it for longer than kSilent: it hangs, or was killed
  absent,      // there is none: it is not running
  unreadable,  // what lies there is no status
};
std::string_view name_of(Contact contact);

// The appliance writes once a second, and a disk may be slow.
constexpr Duration kSilent = std::chrono::seconds(15);

struct Heard {
  Contact contact = Contact::absent;
  std::optional<ToldStatus> status;  // only when heard
  std::string why;                   // why not
  Duration silent{};                 // since it was written
};

// The whole text of a file of at most `most_bytes`, which must be a regular one: no link, pipe or device, which would lead
// elsewhere or never end. Errors: bad_input (absent, another kind, larger), io.
Result<std::string> read_distrusted_file(const std::filesystem::path& path, std::size_t most_bytes);

class StatusWatch {
 public:
  StatusWatch(std::filesystem::path file, Clock& clock) : file_(std::move(file)), clock_(clock) {}
  // BLOCKS for as long as reading a small file takes. Call it about once a second.
  Heard look();

 private:
  std::filesystem::path file_;
  Clock& clock_;
  std::string text_;  // as it was last
  std::optional<Instant> changed_;
};

}  // namespace kasumi::report
