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

enum class What { create, write, cut, sync, rename, remove, folder, link };

struct Call {
  What what;
  std::string path;    // below the folder; "" is the folder itself
  std::string other;   // rename: the new path; link: what it leads to
  std::size_t at = 0;  // write: its place; cut: the new length
  std::vector<char> bytes{};
};

// A file, a link, or a folder with the names in it: as programs see it, and as it is on the disk.
struct Node {
  enum class Kind { file, folder, link } kind = Kind::file;
  std::string now{}, on_disk{};  // contents; of a link where it leads
  std::map<std::string, std::shared_ptr<Node>> names{}, names_on_disk{};
};
using NodePtr = std::shared_ptr<Node>;

inline std::string above(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}
inline std::string last(const std::string& path) {
  return path.substr(path.rfind('/') + 1);  // npos + 1 is 0
}

inline NodePtr find(const NodePtr& root, const std::string& path) {
  if (path.empty()) return root;
  const auto folder = find(root, above(path));
  if (!folder) return nullptr;
  const auto found = folder->names.find(last(path));
  return found == folder->names.end() ? nullptr : found->second;
}

}  // namespace power_cut

using namespace power_cut;

struct PowerCut::Notes {
  std::filesystem::path folder;
  NodePtr before;
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

// What lies there, as it is on the disk.
NodePtr read_tree(const std::filesystem::path& folder) {
  const auto node = std::make_shared<Node>(Node{Node::Kind::folder});
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    auto& at = node->names[entry.path().filename().string()];
    if (entry.is_symlink())
      at = std::make_shared<Node>(Node{Node::Kind::link, std::filesystem::read_symlink(entry.path()).string()});
    else if (entry.is_directory())
      at = read_tree(entry.path());
    else
      at = std::make_shared<Node>(Node{Node::Kind::file, read_text_file(entry.path()).value()});
    at->on_disk = at->now;
  }
  node->names_on_disk = node->names;
  return node;
}

NodePtr copy_of(const NodePtr& node, std::map<NodePtr, NodePtr>& copies) {
  auto& copy = copies[node];
  if (copy) return copy;
  copy = std::make_shared<Node>(*node);
  for (auto& [name, child] : copy->names) child = copy_of(child, copies);
  for (auto& [name, child] : copy->names_on_disk) child = copy_of(child, copies);
  return copy;
}

void make(const NodePtr& root, const Call& call, Node node) {
  if (const auto folder = find(root, above(call.path)); folder && !folder->names.contains(last(call.path)))
    folder->names[last(call.path)] = std::make_shared<Node>(std::move(node));
}

// As POSIX has it: the node moves with all that is in it, on the disk once the folders' names are.
void move_node(const NodePtr& root, const std::string& from, const std::string& to) {
  const auto old_folder = find(root, above(from)), new_folder = find(root, above(to));
  const auto node = find(root, from);
  if (!node || !new_folder) return;
  old_folder->names.erase(last(from));
  new_folder->names[last(to)] = node;
}

void happen(const NodePtr& root, const Call& call) {
  const auto node = find(root, call.path);
  switch (call.what) {
    case What::create: return make(root, call, {Node::Kind::file});
    case What::folder: return make(root, call, {Node::Kind::folder});
    case What::link: return make(root, call, {Node::Kind::link, call.other, call.other});
    case What::rename: return move_node(root, call.path, call.other);
    case What::remove:
      if (node) find(root, above(call.path))->names.erase(last(call.path));
      return;
    case What::write:
      if (!node) return;
      if (node->now.size() < call.at + call.bytes.size()) node->now.resize(call.at + call.bytes.size());
      node->now.replace(call.at, call.bytes.size(), call.bytes.data(), call.bytes.size());
      return;
    case What::cut:
      if (node) node->now.resize(call.at);
      return;
    case What::sync:
      if (!node) return;
      node->on_disk = node->now;
      node->names_on_disk = node->names;
  }
}

void put(const Node& folder, bool names, bool contents, const std::filesystem::path& to) {
  std::filesystem::create_directories(to);
  for (const auto& [name, node] : names ? folder.names : folder.names_on_disk) {
    const auto& bytes = contents ? node->now : node->on_disk;
    if (node->kind == Node::Kind::folder)
      put(*node, names, contents, to / name);
    else if (node->kind == Node::Kind::link)
      std::filesystem::create_symlink(bytes, to / name);
    else
      std::ofstream(to / name, std::ios::binary) << bytes;
  }
}

}  // namespace

PowerCut::PowerCut(std::filesystem::path folder) : notes_(std::make_unique<Notes>()) {
  notes_->folder = std::filesystem::absolute(folder).lexically_normal();
  notes_->before = read_tree(notes_->folder);
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
  std::map<NodePtr, NodePtr> copies;
  const auto root = copy_of(notes_->before, copies);
  for (std::size_t i = 0; i < count; ++i) happen(root, notes_->calls[i]);
  std::filesystem::remove_all(to);
  const bool names = left == Left::names || left == Left::names_and_contents;
  const bool contents = left == Left::contents || left == Left::names_and_contents;
  put(*root, names, contents, to);
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

extern "C" int symlink(const char* target, const char* path) noexcept {
  static const auto real = kasumi::next<int(const char*, const char*)>("symlink");
  const int done = real(target, path);
  if (done == 0)
    if (auto* notes = kasumi::watching.load())
      if (const auto name = notes->inside(std::filesystem::path(path))) notes->note({What::link, *name, target, 0, {}});
  return done;
}
