#include "tests/base/power_cut.hpp"

#include <atomic>
#include <cstdarg>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/files.hpp"

namespace kasumi {

namespace power_cut {

enum class What { create, write, cut, sync, rename, remove, folder };

struct Call {
  What what;
  std::string path;    // below the folder; "" is the folder itself
  std::string other;   // rename: the new path
  std::size_t at = 0;  // write: its place; cut: the new length
  std::vector<char> bytes{};
};

struct File {
  bool folder = false;
  std::string now, on_disk;
};
using Names = std::map<std::string, std::shared_ptr<File>>;

inline std::string above(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

}  // namespace power_cut

using namespace power_cut;

struct PowerCut::Notes {
  std::filesystem::path folder;
  Names before;
  mutable std::mutex mutex;
  std::vector<Call> calls;

  // Empty optional: not below the folder.
  std::optional<std::string> inside(std::filesystem::path path) const {
    const auto below = std::filesystem::absolute(path).lexically_normal().lexically_relative(folder).string();
    if (below == ".") return "";
    if (below.empty() || below.starts_with("..")) return std::nullopt;
    return below.ends_with('/') ? below.substr(0, below.size() - 1) : below;
  }
  std::optional<std::string> inside(int fd) const {
    char name[4096];
    const auto length = ::readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), name, sizeof name);
    return length > 0 ? inside(std::string(name, static_cast<std::size_t>(length))) : std::nullopt;
  }
  void note(Call call) {
    const std::lock_guard lock(mutex);
    calls.push_back(std::move(call));
  }
};

namespace {

std::atomic<PowerCut::Notes*> watching{nullptr};

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

// Notes a call that succeeded, of a path or of an open file.
template <class Place>
void note(What what, const Place& place, std::size_t at = 0, std::vector<char> bytes = {}) {
  auto* notes = watching.load();
  if (!notes) return;
  const int before = errno;
  if (auto path = notes->inside(place)) notes->note({what, *path, "", at, std::move(bytes)});
  errno = before;
}

int opened(const char* path, int flags, int fd) {
  if (fd < 0) return fd;
  if (flags & O_CREAT) note(What::create, path);
  if (flags & O_TRUNC) note(What::cut, path);
  return fd;
}

// Of `names`, those directly in the folder.
Names in_folder(const Names& names, const std::string& folder) {
  Names found;
  for (const auto& [path, file] : names)
    if (above(path) == folder) found.emplace(path, file);
  return found;
}

void move_name(Names& names, const std::string& from, const std::string& to) {
  if (const auto found = names.find(from); found != names.end()) {
    names[to] = found->second;
    names.erase(from);
  }
}

}  // namespace

PowerCut::PowerCut(std::filesystem::path folder) : notes_(std::make_unique<Notes>()) {
  notes_->folder = std::filesystem::absolute(folder).lexically_normal();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(notes_->folder)) {
    auto file = std::make_shared<File>(File{entry.is_directory(), "", ""});
    if (!file->folder) file->now = file->on_disk = read_text_file(entry.path()).value();
    notes_->before[*notes_->inside(entry.path())] = file;
  }
  watching = notes_.get();
}

PowerCut::~PowerCut() {
  watching = nullptr;
}

std::size_t PowerCut::calls() const {
  const std::lock_guard lock(notes_->mutex);
  return notes_->calls.size();
}

void PowerCut::lay_out(std::size_t count, Left left, const std::filesystem::path& to) const {
  Names seen, on_disk;
  for (const auto& [path, file] : notes_->before) seen[path] = on_disk[path] = std::make_shared<File>(*file);
  for (std::size_t i = 0; i < count; ++i) {
    const Call& call = notes_->calls[i];
    const auto file = seen.find(call.path);
    switch (call.what) {
      case What::create:
      case What::folder:
        if (file == seen.end()) seen[call.path] = std::make_shared<File>(File{call.what == What::folder, "", ""});
        break;
      case What::write:
        if (file == seen.end()) break;
        if (file->second->now.size() < call.at + call.bytes.size())
          file->second->now.resize(call.at + call.bytes.size());
        file->second->now.replace(call.at, call.bytes.size(), call.bytes.data(), call.bytes.size());
        break;
      case What::cut:
        if (file != seen.end()) file->second->now.resize(call.at);
        break;
      case What::sync:
        if (call.path.empty() || (file != seen.end() && file->second->folder)) {
          for (const auto& [path, was] : in_folder(on_disk, call.path)) on_disk.erase(path);
          on_disk.merge(in_folder(seen, call.path));
        } else if (file != seen.end()) {
          file->second->on_disk = file->second->now;
        }
        break;
      case What::rename: move_name(seen, call.path, call.other); break;
      case What::remove: seen.erase(call.path); break;
    }
  }
  std::filesystem::remove_all(to);
  std::filesystem::create_directories(to);
  const bool names = left == Left::names || left == Left::names_and_contents;
  const bool contents = left == Left::contents || left == Left::names_and_contents;
  for (const auto& [path, file] : names ? seen : on_disk) {  // a folder comes before what is in it
    if (file->folder)
      std::filesystem::create_directory(to / path);
    else if (std::filesystem::is_directory((to / path).parent_path()))  // else its folder was lost
      std::ofstream(to / path, std::ios::binary) << (contents ? file->now : file->on_disk);
  }
}

}  // namespace kasumi

using kasumi::power_cut::What;

extern "C" int open(const char* path, int flags, ...) {
  static const auto real = kasumi::next<int(const char*, int, ...)>("open");
  va_list more;
  va_start(more, flags);
  const auto mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
  va_end(more);
  return kasumi::opened(path, flags, real(path, flags, mode));
}

extern "C" ssize_t write(int fd, const void* data, std::size_t size) {
  static const auto real = kasumi::next<ssize_t(int, const void*, std::size_t)>("write");
  const auto n = real(fd, data, size);
  if (n > 0 && kasumi::watching.load()) {
    const auto* bytes = static_cast<const char*>(data);
    kasumi::note(What::write, fd, static_cast<std::size_t>(::lseek(fd, 0, SEEK_CUR) - n), {bytes, bytes + n});
  }
  return n;
}

extern "C" int ftruncate(int fd, off_t length) noexcept {
  static const auto real = kasumi::next<int(int, off_t)>("ftruncate");
  const int done = real(fd, length);
  if (done == 0) kasumi::note(What::cut, fd, static_cast<std::size_t>(length));
  return done;
}

extern "C" int fsync(int fd) {
  static const auto real = kasumi::next<int(int)>("fsync");
  const int done = real(fd);
  if (done == 0) kasumi::note(What::sync, fd);
  return done;
}

extern "C" int fdatasync(int fd) {
  static const auto real = kasumi::next<int(int)>("fdatasync");
  const int done = real(fd);
  if (done == 0) kasumi::note(What::sync, fd);
  return done;
}

extern "C" int rename(const char* from, const char* to) noexcept {
  static const auto real = kasumi::next<int(const char*, const char*)>("rename");
  auto* notes = kasumi::watching.load();
  const auto old_name = notes ? notes->inside(std::filesystem::path(from)) : std::nullopt;
  const int done = real(from, to);
  if (done == 0 && old_name)
    if (const auto name = notes->inside(std::filesystem::path(to)))
      notes->note({What::rename, *old_name, *name, 0, {}});
  return done;
}

extern "C" int remove(const char* path) noexcept {
  static const auto real = kasumi::next<int(const char*)>("remove");
  const int done = real(path);
  if (done == 0) kasumi::note(What::remove, std::filesystem::path(path));
  return done;
}

extern "C" int mkdir(const char* path, mode_t mode) noexcept {
  static const auto real = kasumi::next<int(const char*, mode_t)>("mkdir");
  const int done = real(path, mode);
  if (done == 0) kasumi::note(What::folder, std::filesystem::path(path));
  return done;
}
