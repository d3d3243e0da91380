// Preloaded into kasumi by its tests: a disk that does not answer. The file named by KASUMI_HUNG_DISK has lines
// "open TEXT" and "fsync TEXT": such calls for files whose names hold TEXT wait until the line has gone; "open" also
// where a socket is made. "fail TEXT": what is read of such a file is an error (EIO), though it can be opened.
// "told TEXT FILE" appends the name of each file that is opened for writing and holds TEXT to FILE. "no thread": none
// can be begun.
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

namespace {

int open_plainly(const char* path, int flags) {
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags | O_CLOEXEC, 0644));
}

// The rest of the line of this verb whose text the name holds; false: there is none.
bool rule_for(const char* verb, const char* name, char* rest, std::size_t size) {
  const char* file = std::getenv("KASUMI_HUNG_DISK");
  const int fd = file && name ? open_plainly(file, O_RDONLY) : -1;
  if (fd < 0) return false;
  char rules[2048]{};
  const auto length = ::syscall(SYS_read, fd, rules, sizeof rules - 1);
  ::close(fd);
  if (length <= 0) return false;
  char* save = nullptr;
  for (char* line = ::strtok_r(rules, "\n", &save); line; line = ::strtok_r(nullptr, "\n", &save)) {
    char is[16]{}, text[512]{}, more[512]{};
    if (std::sscanf(line, "%15s %511s %511s", is, text, more) < 2) continue;
    if (std::strcmp(is, verb) != 0 || !std::strstr(name, text)) continue;
    std::snprintf(rest, size, "%s", more);
    return true;
  }
  return false;
}

void wait_for_disk(const char* verb, const char* name) {
  char rest[512];
  while (rule_for(verb, name, rest, sizeof rest)) ::usleep(20'000);
}

void before_opening(const char* name, int flags) {
  const int before = errno;
  wait_for_disk("open", name);
  char file[512];
  if ((flags & O_ACCMODE) != O_RDONLY && rule_for("told", name, file, sizeof file)) {
    const int fd = open_plainly(file, O_WRONLY | O_APPEND | O_CREAT);
    ::syscall(SYS_write, fd, name, std::strlen(name));
    ::syscall(SYS_write, fd, "\n", 1);
    ::close(fd);
  }
  errno = before;
}

// The kernel's own file whose first bytes cannot be read stands for one on a failing disk.
int open_on_that_disk(const char* name, int flags, mode_t mode) {
  before_opening(name, flags);
  char rest[512];
  const int before = errno;
  const bool fails = (flags & O_ACCMODE) == O_RDONLY && rule_for("fail", name, rest, sizeof rest);
  errno = before;
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, fails ? "/proc/self/mem" : name, flags, mode));
}

mode_t mode_of(int flags, va_list& arguments) {
  return flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

extern "C" int open(const char* name, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return open_on_that_disk(name, flags, mode);
}

extern "C" int open64(const char* name, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return open_on_that_disk(name, flags, mode);
}

extern "C" int bind(int socket, const sockaddr* address, socklen_t length) {
  const int before = errno;
  if (address->sa_family == AF_UNIX) wait_for_disk("open", reinterpret_cast<const sockaddr_un*>(address)->sun_path);
  errno = before;
  return static_cast<int>(::syscall(SYS_bind, socket, address, length));
}

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* with) {
  static const auto create = reinterpret_cast<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>(
      ::dlsym(RTLD_NEXT, "pthread_create"));
  char rest[512];
  return rule_for("no", "thread", rest, sizeof rest) ? EAGAIN : create(thread, attributes, run, with);
}

extern "C" int fsync(int fd) {
  char link[64], name[1024]{};
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  if (::readlink(link, name, sizeof name - 1) > 0) wait_for_disk("fsync", name);
  return static_cast<int>(::syscall(SYS_fsync, fd));
}
