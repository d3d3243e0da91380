#include "capture/fixture_writer.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <fcntl.h>
#include <unistd.h>

#include "base/files.hpp"

namespace kasumi {

namespace {

std::string extension_of(FourCc format) {
  if (format == kMjpg) return "jpg";
  auto extension = format.text();
  for (auto& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

// Whole or not at all: half a line would swallow the next one.
Result<> append_line(int fd, const std::filesystem::path& path, std::string line) {
  line += '\n';
  const auto before = ::lseek(fd, 0, SEEK_END);
  std::string_view rest = line;
  while (!rest.empty()) {
    const auto n = ::write(fd, rest.data(), rest.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const auto reason = errno;
      const bool undone = ::ftruncate(fd, before) == 0;
      return fail(FaultKind::io, "{}: writing failed: {}{}", path.string(), std::strerror(reason),
                  undone ? "" : "; its last line is incomplete");
    }
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

}  // namespace

Result<FixtureWriter> FixtureWriter::create(const std::filesystem::path& camera_folder, FixtureWriterOptions options) {
  std::error_code error;
  std::filesystem::create_directories(camera_folder, error);
  if (error) return fail(FaultKind::io, "{}: cannot be created: {}", camera_folder.string(), error.message());
  const auto path = camera_folder / "index.csv";
  UniqueFd index(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644));
  if (!index && errno == EEXIST)
    return fail(FaultKind::bad_input, "{}: exists already; expected a folder without a recording", path.string());
  if (!index) return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), std::strerror(errno));
  if (auto written = append_line(index.value(), path, std::string(kIndexHeader)); !written)
    return fail(written.error());
  return FixtureWriter(camera_folder, std::move(index), options);
}

Result<> FixtureWriter::append(const Frame& frame) {
  if (auto possible = check_geometry(frame.metadata); !possible) return possible;
  auto name = store(frame);
  if (!name) return fail(name.error());
  IndexRow row;
  row.metadata = frame.metadata;
  row.payload = std::move(*name);
  return append_row(row);
}

Result<> FixtureWriter::append_disconnect(Instant at, Utc utc) {
  IndexRow row;
  row.metadata.captured_at = at;
  row.metadata.utc = utc;
  row.disconnected = true;
  return append_row(row);
}

Result<std::string> FixtureWriter::store(const Frame& frame) {
  const auto payload = frame.payload.bytes;
  const auto bytes = payload.first(std::min<std::size_t>(payload.size(), frame.metadata.bytes_used));
  if (bytes.empty()) return std::string();
  std::uint64_t hash = 0;
  if (options_.share_equal_payloads) {
    hash = std::hash<std::string_view>{}({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (const auto known = names_.find(hash); known != names_.end()) {
      const auto stored = read_file(folder_ / known->second);
      if (stored && std::equal(stored->begin(), stored->end(), bytes.begin(), bytes.end())) return known->second;
    }
  }
  const auto name = fmt::format("frame-{:06}.{}", payload_count_, extension_of(frame.metadata.format));
  if (auto written = write_file(folder_ / name, bytes); !written) return fail(written.error());
  ++payload_count_;
  bytes_written_ += bytes.size();
  if (options_.share_equal_payloads) names_[hash] = name;
  return name;
}

Result<> FixtureWriter::append_row(const IndexRow& row) {
  const auto line = index_line(row);
  auto written = append_line(index_.value(), folder_ / "index.csv", line);
  if (!written) return written;
  ++row_count_;
  bytes_written_ += line.size() + 1;
  return {};
}

}  // namespace kasumi
