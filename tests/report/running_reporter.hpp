// The program as the service manager runs it, on a port of its own, and a peer that says what it likes.
#pragma once

#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/unique_fd.hpp"
#include "tests/places.hpp"
#include "tests/report/told.hpp"

namespace kasumi::report {

inline std::filesystem::path report_folder(const std::string& name) {
  const auto folder = test_output_folder() / "report" / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

inline std::filesystem::path report_program() {
  return kasumi_program().parent_path() / "kasumi-report";
}

// Connected to a port of this machine; none: it was refused.
inline UniqueFd connected(int port) {
  UniqueFd fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd.value(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return UniqueFd();
  return fd;
}

// False: the other side does not take it.
inline bool sent(const UniqueFd& fd, std::string_view bytes) {
  return ::send(fd.value(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

// All that comes until the other side is done, or for `longest_ms` nothing does.
inline std::string heard_from(const UniqueFd& fd, int longest_ms = 5000) {
  std::string all;
  char buffer[4096];
  for (pollfd ready{fd.value(), POLLIN, 0}; ::poll(&ready, 1, longest_ms) > 0;) {
    const auto n = ::recv(fd.value(), buffer, sizeof buffer, 0);
    if (n <= 0) break;
    all.append(buffer, static_cast<std::size_t>(n));
  }
  return all;
}

// A port that nobody listened at a moment ago.
inline int free_port() {
  const UniqueFd fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(fd.value(), reinterpret_cast<sockaddr*>(&address), length) != 0) return 0;
  ::getsockname(fd.value(), reinterpret_cast<sockaddr*>(&address), &length);
  return ntohs(address.sin_port);
}

inline bool within(double seconds, const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (is_so()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return is_so();
}

// A program that ends with this object.
class Child {
 public:
  // Its output goes to `log`.
  Child(const std::vector<std::string>& command, const std::filesystem::path& log) {
    std::vector<char*> arguments;
    for (const auto& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ != 0) return;
    if (!std::freopen(log.c_str(), "w", stdout) || ::dup2(1, 2) < 0) ::_exit(126);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ~Child() { stop(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int pid() const { return pid_; }
  bool runs() const { return pid_ > 0 && ::waitpid(pid_, nullptr, WNOHANG) == 0; }
  int stop(int signal = SIGTERM) {
    if (pid_ <= 0) return -1;
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  // From /proc: "VmRSS", in kB.
  double memory_kb() const {
    const auto text = read_text_file(fmt::format("/proc/{}/status", pid_)).value_or("");
    const auto at = text.find("VmRSS:");
    return at == std::string::npos ? 0.0 : std::stod(text.substr(at + 6));
  }

 private:
  pid_t pid_ = -1;
};

// A reporter whose appliance writes what a test says.
class RunningReporter {
 public:
  // `more`: of report.toml, after [http]'s port.
  explicit RunningReporter(const std::string& name, const std::string& more = {}, const std::string& before = {})
      : folder(report_folder(name)), port(free_port()) {
    tell(kGoodStatus);
    EXPECT_TRUE(write_text_file(folder / "report.toml",
                                fmt::format("[kiosk]\nstatus = \"{0}/status.json\"\nstate = \"{0}\"\n{1}\n[http]\n"
                                            "port = {2}\n{3}\n",
                                            folder.string(), before, port, more)));
    child_.emplace(std::vector<std::string>{report_program(), "run", "--config", folder / "report.toml"},
                   folder / "log");
    EXPECT_TRUE(within(20, [&] { return bool(connected(port)); })) << log();
  }
  void tell(const std::string& status) { EXPECT_TRUE(write_text_file(folder / "status.json", status)); }
  // The answer to a GET, or a POST without a body, with these header lines.
  std::string get(const std::string& path, const std::string& headers = {}) const { return ask("GET", path, headers); }
  std::string post(const std::string& path, const std::string& headers = {}) const {
    return ask("POST", path, "Content-Length: 0\r\n" + headers);
  }
  std::string metrics() const { return get("/metrics"); }
  std::string log() const { return read_text_file(folder / "log").value_or(""); }
  Child& child() { return *child_; }

  const std::filesystem::path folder;
  const int port;

 private:
  std::string ask(std::string_view method, const std::string& path, const std::string& headers) const {
    const auto fd = connected(port);
    if (!fd || !sent(fd, fmt::format("{} {} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{}\r\n", method, path,
                                     headers)))
      return {};
    return heard_from(fd, 15000);
  }
  std::optional<Child> child_;
};

// The address that the page's button sends its form to; empty: there is none.
inline std::string form_action(const std::string& page) {
  constexpr std::string_view kBefore = "<form method=\"post\" action=\".";
  const auto at = page.find(kBefore);
  if (at == std::string::npos) return {};
  auto action = page.substr(at + kBefore.size(), page.find('"', at + kBefore.size()) - at - kBefore.size());
  for (std::size_t amp; (amp = action.find("&amp;")) != std::string::npos;) action.erase(amp + 1, 4);
  return action;
}

// The pixels of the bitmap within a page, as a browser would read them; empty: there is none.
inline Image<Rgb8> picture_in(const std::string& page) {
  constexpr std::string_view kBefore = "src=\"data:image/bmp;base64,",
                             kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto at = page.find(kBefore);
  if (at == std::string::npos) return {};
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (auto i = at + kBefore.size(); kLetters.find(page[i]) != std::string_view::npos; ++i) {
    bits = bits << 6 | static_cast<unsigned>(kLetters.find(page[i]));
    if ((held += 6) < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 255u);
  }
  const auto number = [&](std::size_t from, int size) {
    unsigned value = 0;
    for (int i = size; i-- > 0;)
      value = value << 8 | static_cast<unsigned char>(bytes.at(from + static_cast<std::size_t>(i)));
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 2), "BM");
  EXPECT_EQ(number(2, 4), bytes.size());
  EXPECT_EQ(number(28, 2), 24u) << "bits a pixel";
  const auto start = number(10, 4), width = number(18, 4), height = number(22, 4), row = (3 * width + 3) / 4 * 4;
  Image<Rgb8> picture(static_cast<int>(width), static_cast<int>(height));
  for (unsigned y = 0; y < height; ++y)
    for (unsigned x = 0; x < width; ++x)
      for (const unsigned c : {0u, 1u, 2u})
        picture.at(static_cast<int>(x), static_cast<int>(y))[static_cast<int>(c)] =
            static_cast<std::uint8_t>(number(start + (height - 1 - y) * row + 3 * x + 2 - c, 1));
  return picture;
}

// The output of a command, which must not take longer than its own limits.
inline std::string said_by(const std::string& command) {
  std::string all;
  const CPtr<FILE, ::pclose> pipe(::popen((command + " 2>&1").c_str(), "r"));
  char buffer[4096];
  for (std::size_t n; pipe && (n = std::fread(buffer, 1, sizeof buffer, pipe.get())) > 0;) all.append(buffer, n);
  return all;
}

inline bool is_installed(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

}  // namespace kasumi::report
