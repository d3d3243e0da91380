#include "tests/made_once.hpp"

#include <chrono>
#include <cstdint>
#include <cstdio>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "tests/places.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

constexpr std::chrono::hours kKeptUnused{24 * 7};  // what another generator made

std::uint64_t fnv1a(const std::string& text) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  return hash;
}

// Held until the end of the scope, or of the process.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& file) : fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    while (fd_ >= 0 && ::flock(fd_, LOCK_EX) != 0) {
    }
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }

 private:
  int fd_;
};

fs::path open_store() {
  const auto folder = made_once_folder();
  std::error_code failed;
  const bool fresh = fs::create_directories(folder, failed);
  fs::last_write_time(folder, fs::file_time_type::clock::now(), failed);
  if (!fresh) return folder;
  for (const auto& other : fs::directory_iterator(folder.parent_path(), failed))
    if (fs::file_time_type::clock::now() - other.last_write_time(failed) > kKeptUnused)
      fs::remove_all(other.path(), failed);
  return folder;
}

}  // namespace

fs::path made_once_store() {
  static const fs::path kStore = open_store();
  return kStore;
}

fs::path made_once(const std::string& name, const std::string& description,
                   const std::function<bool(const fs::path&)>& make) {
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(fnv1a(description)));
  const auto folder = made_once_store() / (name + "-" + hash);
  if (fs::exists(folder)) return folder;
  const FolderLock lock(folder.string() + ".lock");
  if (fs::exists(folder)) return folder;
  // Left by a process that was ended, if it is there.
  const auto unfinished = fs::path(folder.string() + ".part");
  fs::remove_all(unfinished);
  if (!make(unfinished)) return {};
  fs::rename(unfinished, folder);
  return folder;
}

}  // namespace kasumi
