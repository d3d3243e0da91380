#include "capture/fixture.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/files.hpp"
#include "capture/utc_text.hpp"

namespace kasumi {

namespace {

enum Column {
  monotonic,
  utc,
  sequence,
  four_cc_text,
  width,
  height,
  stride,
  bytes_used,
  exposure,
  gain,
  flags,
  payload
};
constexpr std::array<std::string_view, 12> kColumns{"monotonic_ns", "utc",    "sequence", "fourcc",
                                                    "width",        "height", "stride",   "bytes_used",
                                                    "exposure_s",   "gain",   "flags",    "payload"};
constexpr std::size_t kMostProblems = 20;
// Twice as long a machine's uptime as anybody has seen; leaves room for adding a recording's length many times.
constexpr std::int64_t kLatestMonotonic = std::int64_t{1} << 61;
// Farther apart than any recording: a timestamp that would make a replay wait for ever.
constexpr Duration kLongestRecording = std::chrono::hours{24 * 366};

std::string shown(std::string_view text) {
  std::string copy(text.substr(0, 40));
  for (auto& c : copy)
    if (c < ' ' || c > '~') c = '?';
  return copy + (text.size() > 40 ? "..." : "");
}

template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

class IndexReader {
 public:
  explicit IndexReader(const std::filesystem::path& folder) : folder_(folder), path_(folder / "index.csv") {}
  Result<std::vector<IndexRow>> read();

 private:
  void read_row(std::string_view line);
  bool split(std::string_view line);
  void problem(Column column, std::string_view expected) {
    const auto name = kColumns[column];
    problems_.add("{}:{}: {} = \"{}\": expected {}", path_.string(), line_, name, shown(fields_[column]), expected);
  }
  template <class Number>
  Number number(Column column, Number highest) {
    const auto value = parse<Number>(fields_[column]);
    if (value && *value >= 0 && *value <= highest) return *value;
    problem(column, fmt::format("a whole number from 0 to {}", highest));
    return 0;
  }
  std::optional<double> optional_number(Column column);
  void read_time(FrameMetadata& metadata);
  void read_picture(FrameMetadata& metadata);
  std::string payload_name();

  std::filesystem::path folder_, path_;
  int line_ = 0;
  std::array<std::string_view, kColumns.size()> fields_;
  std::unordered_map<std::string, bool> is_there_;
  std::vector<IndexRow> rows_;
  Problems problems_;
};

Result<std::vector<IndexRow>> IndexReader::read() {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path_, error))
    return fail(FaultKind::bad_input, "{}: expected the index of a recorded camera; there is no such file",
                path_.string());
  const auto text = read_text_file(path_);
  if (!text) return fail(text.error());

  std::string_view rest = *text;
  bool header_seen = false;
  while (problems_.lines().size() < kMostProblems) {
    const auto end = rest.find('\n');
    if (end == std::string_view::npos) break;
    auto line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    ++line_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    if (header_seen) {
      read_row(line);
    } else if (line != kIndexHeader) {
      return fail(FaultKind::bad_input, "{}:{}: \"{}\": expected the header \"{}\"", path_.string(), line_, shown(line),
                  kIndexHeader);
    }
    header_seen = true;
  }
  if (!problems_.empty()) return fail(problems_.fault());
  return std::move(rows_);
}

bool IndexReader::split(std::string_view line) {
  std::size_t count = 0;
  for (;; ++count) {
    const auto end = line.find(',');
    if (count < fields_.size()) fields_[count] = line.substr(0, end);
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  if (++count == fields_.size()) return true;
  problems_.add("{}:{}: {} columns: expected {}", path_.string(), line_, count, fields_.size());
  return false;
}

void IndexReader::read_row(std::string_view line) {
  if (!split(line)) return;
  IndexRow row;
  row.line = line_;
  auto& metadata = row.metadata;
  read_time(metadata);
  if (fields_[flags] == "disconnected") {
    row.disconnected = true;
  } else {
    if (fields_[flags] == "error")
      metadata.status = FrameStatus::flagged;
    else if (!fields_[flags].empty())
      problem(flags, "nothing, error or disconnected");
    read_picture(metadata);
    row.payload = payload_name();
  }
  rows_.push_back(std::move(row));
}

void IndexReader::read_time(FrameMetadata& metadata) {
  metadata.captured_at = Instant{Duration{number<std::int64_t>(monotonic, kLatestMonotonic)}};
  if (!rows_.empty() && std::chrono::abs(metadata.captured_at - rows_.front().metadata.captured_at) > kLongestRecording)
    problem(monotonic, fmt::format("at most 366 days from the first row's {}",
                                   rows_.front().metadata.captured_at.time_since_epoch().count()));
  if (const auto parsed = parse_utc(fields_[utc]))
    metadata.utc = *parsed;
  else
    problem(utc, "a time like 2026-06-21T03:00:00.040Z");
}

void IndexReader::read_picture(FrameMetadata& metadata) {
  const auto problems_before = problems_.lines().size();
  metadata.sequence = number<std::uint32_t>(sequence, std::numeric_limits<std::uint32_t>::max());
  if (const auto code = parse_four_cc(fields_[four_cc_text]))
    metadata.format = *code;
  else
    problems_.add("{}:{}: fourcc = {}", path_.string(), line_, code.error().message);
  metadata.width = number<int>(width, kLargestSide);
  metadata.height = number<int>(height, kLargestSide);
  metadata.stride = number<std::uint32_t>(stride, kLargestStride);
  metadata.bytes_used = number<std::uint32_t>(bytes_used, kLargestPayload);
  metadata.exposure_s = optional_number(exposure);
  metadata.gain = optional_number(gain);
  if (problems_.lines().size() != problems_before) return;
  if (const auto possible = check_geometry(metadata); !possible)
    problems_.add("{}:{}: {}", path_.string(), line_, possible.error().message);
}

std::optional<double> IndexReader::optional_number(Column column) {
  if (fields_[column].empty()) return std::nullopt;
  const auto value = parse<double>(fields_[column]);
  if (value && std::isfinite(*value) && *value >= 0.0) return value;
  problem(column, "a number >= 0 or nothing");
  return std::nullopt;
}

// A plain file beside the index: a recording from elsewhere must not make anybody read other files or wait on a pipe.
std::string IndexReader::payload_name() {
  std::string name(fields_[payload]);
  if (name.empty()) return name;
  if (name.find_first_of(std::string_view("/\\\0", 3)) != std::string::npos || name == "." || name == "..") {
    problem(payload, "the name of a file beside the index, without a folder");
    return name;
  }
  const auto [known, is_new] = is_there_.try_emplace(name, false);
  if (is_new) {
    std::error_code error;
    known->second = std::filesystem::is_regular_file(std::filesystem::symlink_status(folder_ / name, error));
  }
  if (!known->second) problem(payload, "an existing file beside the index");
  return name;
}

}  // namespace

FixtureInfo read_fixture_info(const ConfigTable& root) {
  // A newer format may mean other things by the same words, so nothing is guessed.
  if (root.integer("format", {}, kFixtureFormat) != kFixtureFormat || !root.has("format"))
    root.problem("format", fmt::format("{}, the format this program knows", kFixtureFormat));
  FixtureInfo info;
  info.name = root.text("name");
  info.description = root.text("description", "");
  info.licence = root.text("licence");
  info.provenance = root.text("provenance");
  info.start_utc = root.utc("start_utc");
  return info;
}

Result<std::vector<IndexRow>> read_index(const std::filesystem::path& camera_folder) {
  return IndexReader(camera_folder).read();
}

std::string index_line(const IndexRow& row) {
  const auto& m = row.metadata;
  const auto at = m.captured_at.time_since_epoch().count();
  if (row.disconnected) return fmt::format("{},{},,,,,,,,,disconnected,", at, utc_text(m.utc));
  const auto shown_or_empty = [](const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; };
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}", at, utc_text(m.utc), m.sequence, m.format.text(), m.width,
                     m.height, m.stride, m.bytes_used, shown_or_empty(m.exposure_s), shown_or_empty(m.gain),
                     m.status == FrameStatus::flagged ? "error" : "", row.payload);
}

}  // namespace kasumi
