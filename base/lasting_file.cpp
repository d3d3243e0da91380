#include "base/lasting_file.hpp"

#include <cerrno>
#include <cstring>

#include <sys/statvfs.h>

#include "base/files.hpp"
#include "base/unfinished_file.hpp"

namespace kasumi {

Result<bool> update_text_file(const std::filesystem::path& path, std::string_view text) {
  if (const auto old = read_text_file(path); old && *old == text) return false;
  if (auto written = write_text_file(path, text); !written) return fail(written.error());
  return true;
}

Result<> create_folders(const std::filesystem::path& folder) {
  std::error_code error;
  if (folder.empty() || std::filesystem::is_directory(folder, error)) return {};
  const auto above = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
  if (auto made = create_folders(above); !made) return made;
  if (!std::filesystem::create_directory(folder, error) && error)
    return fail(FaultKind::io, "{}: cannot be created: {}", folder.string(), error.message());
  return write_through_names(above.empty() ? "." : above);
}

Result<std::uint64_t> free_bytes_of(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0)
    return fail(FaultKind::io, "{}: {}", folder.string(), std::strerror(errno));
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

}  // namespace kasumi
