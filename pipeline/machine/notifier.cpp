#include "pipeline/machine/notifier.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <deque>

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "base/thread_annotations.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

// systemd's protocol (sd_notify(3)). libsystemd's own sd_notify waits while the manager does not read, and every loop
// that reports something would block with it.
class SystemdNotifier final : public Notifier {
 public:
  SystemdNotifier() {
    const char* path = std::getenv("NOTIFY_SOCKET");
    const std::string name = path ? path : "";
    if (name.size() < 2 || name.size() >= sizeof manager_.sun_path) return;
    manager_.sun_family = AF_UNIX;
    name.copy(manager_.sun_path, name.size());
    if (name[0] == '@') manager_.sun_path[0] = '\0';  // Linux's abstract names
    length_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size() + (name[0] == '@' ? 0 : 1));
    socket_ = UniqueFd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  }

  void ready() override { send("READY", "1"); }
  void status(const std::string& line) override {
    auto one_line = line;
    std::replace(one_line.begin(), one_line.end(), '\n', ' ');
    send("STATUS", one_line);
  }
  void alive() override { send("WATCHDOG", "1"); }
  void extend_start(Duration by) override {
    send("EXTEND_TIMEOUT_USEC", fmt::to_string(std::chrono::duration_cast<std::chrono::microseconds>(by).count()));
  }
  void reloading() override {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    send("RELOADING",
         fmt::format("1\nMONOTONIC_USEC={}", std::chrono::duration_cast<std::chrono::microseconds>(now).count()));
  }
  void stopping() override { send("STOPPING", "1"); }

 private:
  struct Message {
    const char* key;
    std::string text;
  };

  // A message that the manager does not take now is sent before the next one; of each key the newest is enough.
  void send(const char* key, const std::string& value) {
    if (!socket_) return;
    const MutexLock lock(mutex_);
    std::erase_if(waiting_, [&](const Message& message) { return std::string_view(message.key) == key; });
    waiting_.push_back({key, fmt::format("{}={}", key, value)});
    while (!waiting_.empty() && !must_wait(waiting_.front().text)) waiting_.pop_front();
  }
  bool must_wait(const std::string& text) const {
    return ::sendto(socket_.value(), text.data(), text.size(), MSG_NOSIGNAL,
                    reinterpret_cast<const sockaddr*>(&manager_), length_) < 0 &&
           (errno == EAGAIN || errno == ENOBUFS || errno == EINTR);
  }

  sockaddr_un manager_{};
  socklen_t length_ = 0;
  UniqueFd socket_;  // none without a service manager
  Mutex mutex_;
  std::deque<Message> waiting_ KASUMI_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Notifier> notify_systemd() {
  return std::make_unique<SystemdNotifier>();
}

}  // namespace kasumi
