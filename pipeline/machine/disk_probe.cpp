#include "pipeline/machine/disk_probe.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/unique_fd.hpp"
#include "pipeline/machine/account.hpp"

namespace kasumi {
namespace {

struct Outcome {
  int error = 0;
  double seconds = 0.0;
};

double now_s() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

int write_through(int file, const std::vector<std::uint8_t>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto n = ::write(file, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  return ::fsync(file) == 0 ? 0 : errno;
}

// In a child of a process with threads: system calls only.
Outcome write_and_remove(int folder, const char* name, const Account& account, const std::vector<std::uint8_t>& bytes) {
  if (account.other && !change_to(account)) return {errno, 0.0};
  const double began = now_s();
  const int file = ::openat(folder, name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (file < 0) return {errno, 0.0};
  const int error = write_through(file, bytes);
  const double seconds = now_s() - began;
  ::close(file);
  ::unlinkat(folder, name, 0);
  return {error, seconds};
}

}  // namespace

Result<DiskProbe> probe_disk(const std::filesystem::path& folder, std::size_t bytes, Duration longest) {
  const UniqueFd fd(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  struct stat status {};
  if (!fd || ::fstat(fd.value(), &status) != 0)
    return fail(FaultKind::io, "{}: {}", folder.string(), std::strerror(errno));
  const auto account = account_for(status);
  std::uint64_t number = 0;
  int ends[2];
  if (::getrandom(&number, sizeof number, 0) != sizeof number || ::pipe2(ends, O_CLOEXEC) != 0)
    return fail(FaultKind::io, "{}: cannot be tried: {}", folder.string(), std::strerror(errno));
  const UniqueFd here(ends[0]);
  UniqueFd there(ends[1]);
  const auto name = fmt::format(".probe-{:016x}.part", number);
  const std::vector<std::uint8_t> content(bytes, 0x5a);
  const pid_t child = ::fork();
  if (child < 0) return fail(FaultKind::io, "{}: cannot be tried: {}", folder.string(), std::strerror(errno));
  if (child == 0) {
    const auto outcome = write_and_remove(fd.value(), name.c_str(), account, content);
    const auto told = ::write(there.value(), &outcome, sizeof outcome);
    ::_exit(told == sizeof outcome ? 0 : 1);
  }
  there = UniqueFd();
  DiskProbe probe{0, false, 0.0, account.name};
  pollfd answer{here.value(), POLLIN, 0};
  const auto longest_ms = std::chrono::duration_cast<std::chrono::milliseconds>(longest).count();
  int ready = 0;
  do {
    ready = ::poll(&answer, 1, static_cast<int>(longest_ms));
  } while (ready < 0 && errno == EINTR);
  if (ready <= 0) {
    ::kill(child, SIGKILL);  // stuck in the kernel it may outlive this process: it is not waited for
    ::waitpid(child, nullptr, WNOHANG);
    probe.hangs = true;
    probe.error = ETIMEDOUT;
    probe.seconds = to_seconds(longest);
    return probe;
  }
  Outcome outcome;
  if (::read(here.value(), &outcome, sizeof outcome) != sizeof outcome) outcome.error = EIO;
  ::waitpid(child, nullptr, 0);
  probe.error = outcome.error;
  probe.seconds = outcome.seconds;
  return probe;
}

}  // namespace kasumi
