#include "base/disk/free_space.hpp"

#include <cerrno>
#include <cstring>

#include <sys/statvfs.h>

namespace kasumi {

Result<std::uint64_t> free_bytes_of(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0)
    return fail(FaultKind::io, "{}: {}", folder.string(), std::strerror(errno));
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

}  // namespace kasumi
