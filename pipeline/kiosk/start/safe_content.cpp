#include "pipeline/kiosk/start/safe_content.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <memory>
#include <new>
#include <thread>

#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/picture_header.hpp"

namespace kasumi {

namespace {

template <std::size_t kSize>
struct Text {
  char bytes[kSize];
  void put(std::string_view text) { bytes[text.copy(bytes, kSize - 1)] = '\0'; }
  std::string get() const { return {bytes, ::strnlen(bytes, kSize)}; }
};

// What the reader has found, in memory that both processes see: plain numbers and bytes, so that nothing has to be parsed
// again.
struct Found {
  std::atomic<bool> has_screen, has_still, has_remark;
  enum class Kind { kms, window, headless } kind;
  Text<512> device;
  Text<64> connector;
  int width, height;
  double refresh_hz;
  bool preferred_instead, atomic;
  Text<4096> caption;
  Language language;
  bool show_faults, sharp, screen_picture;
  int still_width, still_height;
  Text<4096> remark;
};
// Shared with the child: whole pages for what it found, then the still picture's pixels.
constexpr std::size_t kFoundBytes = (sizeof(Found) + 4095) / 4096 * 4096;
constexpr std::size_t kSharedBytes = kFoundBytes + kStillLimits.pixels * sizeof(Rgba8);

std::byte* pixels_of(Found& found) {
  return reinterpret_cast<std::byte*>(&found) + kFoundBytes;
}

void tell(const DisplayOptions& display, Found& found) {
  if (const auto* kms = std::get_if<KmsDisplayOptions>(&display)) {
    found.kind = Found::Kind::kms;
    found.device.put(kms->device);
    found.connector.put(kms->connector);
    found.width = kms->width;
    found.height = kms->height;
    found.refresh_hz = kms->refresh_hz;
    found.preferred_instead = kms->preferred_instead;
    found.atomic = kms->atomic;
  } else if (const auto* window = std::get_if<WindowDisplayOptions>(&display)) {
    found.kind = Found::Kind::window;
    found.width = window->width;
    found.height = window->height;
  } else if (const auto* headless = std::get_if<HeadlessDisplayOptions>(&display)) {
    found.kind = Found::Kind::headless;
    found.width = headless->width;
    found.height = headless->height;
  }
}

DisplayOptions told_display(const Found& found) {
  if (found.kind == Found::Kind::window) {
    WindowDisplayOptions window;
    window.width = found.width;
    window.height = found.height;
    return window;
  }
  if (found.kind == Found::Kind::headless) return HeadlessDisplayOptions{found.width, found.height};
  KmsDisplayOptions kms;
  kms.device = found.device.get();
  kms.connector = found.connector.get();
  kms.width = found.width;
  kms.height = found.height;
  kms.refresh_hz = found.refresh_hz;
  kms.preferred_instead = found.preferred_instead;
  kms.atomic = found.atomic;
  return kms;
}

void remark(Found& found, const std::string& text) {
  found.remark.put(text);
  found.has_remark = true;
}

// In the process that may come to grief.
void read_into(Found& found, const FindConfiguration& find) {
  RunConfig config;
  const auto root = ConfigTable::read_file(find());
  if (!root) return remark(found, root.error().message);
  read_screen(*root, config);
  tell(config.display, found);
  found.caption.put(config.still.caption);
  found.language = config.messages.language;
  found.show_faults = config.messages.show_faults;
  found.sharp = config.snapshot.sharp;
  found.screen_picture = config.snapshot.screen_picture;
  found.has_screen = true;
  if (!config.still.picture) return;
  const auto still = read_still(*config.still.picture);
  if (!still) return remark(found, still.error().message);
  const auto& pixels = still->elements();
  if (pixels.size() > kStillLimits.pixels) return remark(found, "the still picture is too large");
  std::memcpy(pixels_of(found), pixels.data(), pixels.size() * sizeof(Rgba8));
  found.still_width = still->width();
  found.still_height = still->height();
  found.has_still = true;
}

// How the reader came to its end; empty: well.
std::string wait_for(pid_t reader, std::chrono::milliseconds deadline) {
  const auto until = std::chrono::steady_clock::now() + deadline;
  for (int status = 0;; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    const pid_t ended = ::waitpid(reader, &status, WNOHANG);
    if (ended == reader && WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    if (ended == reader)
      return WIFSIGNALED(status) ? fmt::format("reading it crashed: {}", ::strsignal(WTERMSIG(status)))
                                 : "reading it failed";
    if (ended < 0) return "reading it failed";
    if (std::chrono::steady_clock::now() < until) continue;
    ::kill(reader, SIGKILL);  // where a disk holds it, it goes later
    return fmt::format("reading it takes longer than {:.1f} s", static_cast<double>(deadline.count()) / 1000.0);
  }
}

struct Unmap {
  void operator()(Found* found) const { ::munmap(found, kSharedBytes); }
};

// Null: no memory, or no process.
std::unique_ptr<Found, Unmap> read_apart(const FindConfiguration& find, std::chrono::milliseconds deadline) {
  void* shared =
      ::mmap(nullptr, kSharedBytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (shared == MAP_FAILED) return nullptr;
  std::unique_ptr<Found, Unmap> found(new (shared) Found{});
  const pid_t reader = ::fork();
  if (reader == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) ::signal(signal, SIG_DFL);
    try {
      read_into(*found, find);
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  const auto how = reader < 0 ? std::string("no process can be begun to read it") : wait_for(reader, deadline);
  if (!how.empty()) spdlog::warn("the configuration for safe mode: {}", how);
  return found;
}

ContentPtr plain_content() {
  auto content = std::make_shared<Content>();
  KmsDisplayOptions any;
  any.preferred_instead = true;
  content->config.display = any;
  content->config.messages.plain_letters = true;
  return content;
}

}  // namespace

ContentPtr read_safe_content(const FindConfiguration& find, StartMode mode, std::chrono::milliseconds deadline) {
  if (mode == StartMode::plain) return plain_content();
  const auto found = read_apart(find, deadline);
  if (found && found->has_remark) spdlog::warn("{}", found->remark.get());
  if (!found || !found->has_screen) return plain_content();
  auto content = std::make_shared<Content>();
  auto& config = content->config;
  config.display = told_display(*found);
  config.still.caption = found->caption.get();
  config.messages.language = found->language;
  config.messages.show_faults = found->show_faults;
  config.snapshot = {found->sharp, found->screen_picture};
  if (!found->has_still) return content;
  auto still = std::make_shared<Image<Rgba8>>(found->still_width, found->still_height);
  std::memcpy(still->elements().data(), pixels_of(*found), still->elements().size() * sizeof(Rgba8));
  content->still = std::move(still);
  return content;
}

}  // namespace kasumi
