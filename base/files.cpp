#include "base/files.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

std::filesystem::path temporary_name(const std::filesystem::path& path) {
  auto name = path.filename();
  auto stem = name.stem().string();
  return path.parent_path() / fmt::format(".{}.{}.part{}", stem, ::getpid(), name.extension().string());
}

}  // namespace

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    return fail(FaultKind::bad_input, "{}: is a folder, expected a file", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(FaultKind::bad_input, "{}: cannot be read: {}", path.string(), std::strerror(errno));
  std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (file.bad()) return fail(FaultKind::io, "{}: reading failed: {}", path.string(), std::strerror(errno));
  return bytes;
}

Result<std::string> read_text_file(const std::filesystem::path& path) {
  return read_file(path).map(
      [](const std::vector<std::uint8_t>& bytes) { return std::string(bytes.begin(), bytes.end()); });
}

Result<> replace_file(const std::filesystem::path& path,
                      const std::function<Result<>(const std::filesystem::path&)>& write) {
  const auto temporary = temporary_name(path);
  std::error_code error;
  if (auto written = write(temporary); !written) {
    std::filesystem::remove(temporary, error);
    return written;
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    const auto reason = error.message();
    std::filesystem::remove(temporary, error);
    return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), reason);
  }
  // The rename must be on the disk too, because another file may refer to this name and must still find it after a
  // power cut.
  const auto folder = path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
  if (const UniqueFd fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); fd) ::fsync(fd.value());
  return {};
}

Result<> write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  return replace_file(path, [&](const std::filesystem::path& temporary) -> Result<> {
    const UniqueFd fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (!fd) return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), std::strerror(errno));
    for (std::size_t done = 0; done < bytes.size();) {
      const auto n = ::write(fd.value(), bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return fail(FaultKind::io, "{}: writing failed: {}", path.string(), std::strerror(errno));
      done += static_cast<std::size_t>(n);
    }
    // The data must be on the disk before the rename is, or a power cut leaves an empty file under the final name.
    if (::fsync(fd.value()) != 0)
      return fail(FaultKind::io, "{}: writing failed: {}", path.string(), std::strerror(errno));
    return {};
  });
}

Result<> write_text_file(const std::filesystem::path& path, std::string_view text) {
  return write_file(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace kasumi
