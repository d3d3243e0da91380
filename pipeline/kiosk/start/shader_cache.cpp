#include "pipeline/kiosk/start/shader_cache.hpp"

#include <cstdlib>
#include <filesystem>

#include <fcntl.h>
#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "base/outside/abandonable.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

constexpr std::uintmax_t kMostWarmedBytes = 32 << 20;  // ours are .5 MB; any other's must not delay the picture

// As the driver begins: it makes the folder and its index, which are writes.
bool warm(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const UniqueFd index(::open((folder / "index").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0644));
  std::uintmax_t read = 0;
  for (auto entry = std::filesystem::recursive_directory_iterator(folder, error);
       !error && entry != end(entry) && read < kMostWarmedBytes; entry.increment(error))
    if (const auto bytes = read_file(entry->path(), {.most_bytes = kMostWarmedBytes})) read += bytes->size();
  return true;
}

}  // namespace

void warm_shader_cache(Duration longest) {
  const char* named = std::getenv("MESA_SHADER_CACHE_DIR");
  if (!named || !*named) return;
  const auto folder = std::filesystem::path(named) / "mesa_shader_cache";
  if (within<bool>(longest, [folder] { return warm(folder); })) return;
  spdlog::error("{}: does not answer: shaders are compiled anew", named);
  ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
}

}  // namespace kasumi
