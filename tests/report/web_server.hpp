// Web servers with TLS: nginx, as a curator would have it, and one that lies.
#pragma once

#include "tests/report/certificates.hpp"

namespace kasumi::report {

inline bool has_nginx() {
  return std::filesystem::exists("/usr/sbin/nginx");
}

// Of the files in `folder`/www, as "own" of make_certificates(folder).
class WebServer {
 public:
  explicit WebServer(const std::filesystem::path& folder, const std::string& who = "own", const std::string& more = {})
      : port(free_port()), folder_(folder) {
    std::filesystem::create_directories(folder / "www");
    std::string places;
    for (const auto* place : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
      places += fmt::format("{}_temp_path {}/temp;", place, folder.string());
    EXPECT_TRUE(write_text_file(
        folder / "nginx.conf",
        fmt::format(
            "{6}daemon off; master_process off; pid {0}/nginx.pid; error_log {0}/nginx.log;\nevents {{}}\n"
            "http {{ {1}\nlog_format asked '$status $http_range $body_bytes_sent'; access_log {0}/asked asked;\n"
            "server {{ listen 127.0.0.1:{2} ssl; ssl_certificate {0}/{3}.pem; ssl_certificate_key {0}/{3}.key;\n"
            "root {0}/www; {4} }} }}\n{5}",
            folder.string(), places, port, who, more, "", ::geteuid() == 0 ? "user root;\n" : "")));
    start();
  }
  void start() {
    server_.emplace(
        std::vector<std::string>{"/usr/sbin/nginx", "-e", folder_ / "nginx.log", "-c", folder_ / "nginx.conf"},
        folder_ / "nginx.out");
    EXPECT_TRUE(within(20, [&] { return bool(connected(port)); }))
        << read_text_file(folder_ / "nginx.log").value_or("") << read_text_file(folder_ / "nginx.out").value_or("");
  }
  void stop() { server_.reset(); }
  std::string url(const std::string& name) const { return fmt::format("https://127.0.0.1:{}/{}", port, name); }
  // Of each request a line: code, Range, bytes.
  std::string asked() const { return read_text_file(folder_ / "asked").value_or(""); }
  const int port;

 private:
  std::filesystem::path folder_;
  std::optional<Child> server_;
};

// tests/report/lying_server.py: answers everybody in one of its ways.
class LyingServer {
 public:
  LyingServer(const std::filesystem::path& folder, const std::string& way)
      : port(free_port()),
        server_({"python3", source_folder() / "tests/report/lying_server.py", std::to_string(port), folder / "own.pem",
                 folder / "own.key", way},
                folder / "lying.log") {
    EXPECT_TRUE(within(20, [&] { return bool(connected(port)); })) << read_text_file(folder / "lying.log").value_or("");
  }
  std::string url() const { return fmt::format("https://127.0.0.1:{}/hill.kasumi", port); }
  const int port;

 private:
  Child server_;
};

}  // namespace kasumi::report
