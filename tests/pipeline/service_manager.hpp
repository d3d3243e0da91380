// A service manager that only listens.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "base/unique_fd.hpp"

namespace kasumi {

// Between two calls of heard() it is as deaf as one that hangs: the kernel keeps a few messages and refuses the others.
class ServiceManager {
 public:
  ServiceManager() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    EXPECT_NE(::mkdtemp(folder_.data()), nullptr);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_.value(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~ServiceManager() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  // A short one: a socket's path has at most 107 bytes, and a test's own folder may lie deeper.
  std::string path() const { return folder_ + "/notify"; }
  // All messages so far.
  const std::string& heard() {
    char buffer[4096];
    for (ssize_t n; (n = ::recv(socket_.value(), buffer, sizeof buffer, 0)) > 0;)
      heard_.append(buffer, static_cast<std::size_t>(n)).append("\n");
    return heard_;
  }

 private:
  std::string folder_ = "/tmp/kasumi-manager-XXXXXX";
  UniqueFd socket_;
  std::string heard_;
};

}  // namespace kasumi
