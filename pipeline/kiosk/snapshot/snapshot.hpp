// What the glass shows now, sent by the appliance to `kasumi snapshot` over a socket in its runtime folder.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

// Beside status.json; its account and root may open it.
constexpr std::string_view kSnapshotSocket = "snapshot.sock";

enum class SnapshotKind {
  blurred,
  sharp,
  page,  // for the reporter's state page: blurred, too, with a notice to visitors; over another socket
};

struct Snapshot {
  SnapshotKind kind = SnapshotKind::blurred;
  Image<Rgb8> picture;    // empty: nothing is on the glass, or it was refused
  std::string shown;      // "live", "held", ...
  std::string reason;     // why not live, or why there is no picture
  std::string words;      // what stands on the picture, which the blur makes illegible
  bool building = false;  // whether the building is drawn
  bool refused = false;   // a sharp picture that the configuration does not allow
  Utc utc{};
  int screen_width = 0, screen_height = 0;  // pixels
};

// What became of those for the state page since the start.
struct PagePictures {
  bool allowed = false;
  std::uint64_t taken = 0;
  std::optional<Utc> last;
};

// The request, a line: "blurred" or "sharp". Errors: bad_input.
std::string snapshot_request_line(SnapshotKind kind);
Result<SnapshotKind> parse_snapshot_request(std::string_view line);

// The answer: a line of JSON, then the picture's bytes, R G B by rows.
std::string snapshot_answer(const Snapshot& snapshot);
// How many bytes of picture follow that line. Errors: bad_input.
struct SnapshotHeader {
  Snapshot snapshot;  // its picture has its size and is black
  std::size_t picture_bytes = 0;
};
Result<SnapshotHeader> parse_snapshot_header(std::string_view line);

// For people: what is shown, why, the words on it.
std::string snapshot_text(const Snapshot& snapshot);

}  // namespace kasumi
