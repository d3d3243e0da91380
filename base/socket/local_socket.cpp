#include "base/socket/local_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

namespace kasumi {
namespace {

using SocketClock = std::chrono::steady_clock;

Fault socket_fault(const std::filesystem::path& path, int error) {
  const bool nobody = error == ENOENT || error == ENOTDIR || error == ECONNREFUSED;
  const auto kind = nobody ? FaultKind::disconnected : error == EAGAIN ? FaultKind::timeout : FaultKind::io;
  return {kind, fmt::format("{}: {}", path.string(), std::strerror(error))};
}

// A socket's address. The kernel takes 107 characters, so a longer path is named through its open folder.
struct SocketAddress {
  sockaddr_un address{};
  UniqueFd folder;  // open while the address is used

  const sockaddr* generic() const { return reinterpret_cast<const sockaddr*>(&address); }
};

// Errors: disconnected (no such folder), io.
Result<SocketAddress> address_of(const std::filesystem::path& path) {
  SocketAddress found;
  found.address.sun_family = AF_UNIX;
  auto text = path.string();
  if (text.size() >= sizeof found.address.sun_path) {
    found.folder = UniqueFd(::open(path.parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (!found.folder) return fail(socket_fault(path, errno));
    text = fmt::format("/proc/self/fd/{}/{}", found.folder.value(), path.filename().string());
  }
  if (text.size() >= sizeof found.address.sun_path)
    return fail(FaultKind::io, "{}: a socket's name has at most 80 characters", path.string());
  text.copy(found.address.sun_path, text.size());
  return found;
}

UniqueFd local_stream() {
  return UniqueFd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

// Errors: timeout.
Result<> wait_until(std::span<pollfd> waiting, SocketClock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SocketClock::now()).count();
    const int ready = ::poll(waiting.data(), waiting.size(), static_cast<int>(std::max<long long>(0, left)));
    if (ready > 0) return {};
    if (ready == 0) return fail(FaultKind::timeout, "no answer in time");
    if (errno != EINTR) return fail(FaultKind::io, "{}", std::strerror(errno));
  }
}

Result<> wait_until(const UniqueFd& socket, short events, SocketClock::time_point deadline) {
  pollfd waiting{socket.value(), events, 0};
  return wait_until(std::span(&waiting, 1), deadline);
}

bool is_for_later() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

// At least one byte.
Result<std::size_t> read_some(const UniqueFd& socket, char* to, std::size_t most, SocketClock::time_point deadline) {
  for (;;) {
    if (auto ready = wait_until(socket, POLLIN, deadline); !ready) return fail(ready.error());
    const auto read = ::recv(socket.value(), to, most, 0);
    if (read > 0) return static_cast<std::size_t>(read);
    if (read == 0) return fail(FaultKind::disconnected, "the other side hung up");
    if (!is_for_later()) return fail(FaultKind::disconnected, "{}", std::strerror(errno));
  }
}

}  // namespace

Result<UniqueFd> listen_at(const std::filesystem::path& path) {
  const auto address = address_of(path);
  if (!address) return fail(address.error());
  auto socket = local_stream();
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0 && S_ISSOCK(there.st_mode)) ::unlink(path.c_str());
  if (!socket || ::bind(socket.value(), address->generic(), sizeof address->address) != 0 ||
      ::chmod(path.c_str(), 0660) != 0 || ::listen(socket.value(), 4) != 0)
    return fail(FaultKind::io, "{}", socket_fault(path, errno).message);
  return socket;
}

UniqueFd accept_within(const UniqueFd& listening, Duration longest) {
  auto caller = accept_within(std::span(&listening, 1), longest);
  return caller ? std::move(caller->socket) : UniqueFd();
}

std::optional<Caller> accept_within(std::span<const UniqueFd> listening, Duration longest) {
  std::vector<pollfd> waiting;
  for (const auto& socket : listening)
    waiting.push_back({socket.value(), POLLIN, 0});  // poll() passes over those below 0
  if (!wait_until(waiting, SocketClock::now() + longest)) return std::nullopt;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (waiting[i].revents == 0) continue;
    UniqueFd socket(::accept4(waiting[i].fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket) return Caller{i, std::move(socket)};
  }
  return std::nullopt;
}

Result<UniqueFd> connect_to(const std::filesystem::path& path) {
  const auto address = address_of(path);
  if (!address) return fail(address.error());
  auto socket = local_stream();
  if (socket && ::connect(socket.value(), address->generic(), sizeof address->address) == 0) return socket;
  return fail(socket_fault(path, errno));
}

Result<std::string> read_line_within(const UniqueFd& socket, std::size_t largest, Duration longest) {
  const auto deadline = SocketClock::now() + longest;
  std::string line;
  for (char c = 0; line.size() <= largest; line += c) {
    if (auto read = read_some(socket, &c, 1, deadline); !read) return fail(read.error());
    if (c == '\n') return line;
  }
  return fail(FaultKind::bad_input, "a line of more than {} characters", largest);
}

Result<std::string> read_bytes_within(const UniqueFd& socket, std::size_t bytes, Duration longest) {
  const auto deadline = SocketClock::now() + longest;
  std::string all(bytes, '\0');
  for (std::size_t have = 0; have < bytes;) {
    const auto read = read_some(socket, all.data() + have, bytes - have, deadline);
    if (!read) return fail(read.error());
    have += *read;
  }
  return all;
}

Result<> write_within(const UniqueFd& socket, std::string_view bytes, Duration longest) {
  const auto deadline = SocketClock::now() + longest;
  while (!bytes.empty()) {
    if (auto ready = wait_until(socket, POLLOUT, deadline); !ready) return ready;
    const auto sent = ::send(socket.value(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && !is_for_later()) return fail(FaultKind::disconnected, "{}", std::strerror(errno));
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return {};
}

}  // namespace kasumi
