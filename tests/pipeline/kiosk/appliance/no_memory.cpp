// Preloaded into kasumi by its tests: in the thread that the file named by KASUMI_NO_MEMORY names, there is no memory for
// large pieces. The file holds "THREAD BYTES EVERY": of the thread's requests for as many bytes or more, each EVERY-th is
// refused. While there is no such file there is memory.
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

extern "C" void* __libc_malloc(std::size_t bytes);

namespace {

constexpr std::size_t kLarge = 1024;  // smaller ones are never refused: the rule need not be read for each

bool refused(std::size_t bytes) {
  static std::atomic<unsigned> requests{0};
  const char* file = std::getenv("KASUMI_NO_MEMORY");
  const int fd = file ? ::open(file, O_RDONLY | O_CLOEXEC) : -1;
  if (fd < 0) return false;
  char rule[64]{}, thread[32]{}, own[32]{};
  const auto length = ::read(fd, rule, sizeof rule - 1);
  ::close(fd);
  std::size_t least = 0;
  unsigned every = 1;
  if (length <= 0 || std::sscanf(rule, "%31s %zu %u", thread, &least, &every) != 3) return false;
  ::prctl(PR_GET_NAME, own);
  return bytes >= least && std::strcmp(thread, own) == 0 && requests++ % every == 0;
}

}  // namespace

extern "C" void* malloc(std::size_t bytes) {
  const int before = errno;
  if (bytes >= kLarge && refused(bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  errno = before;
  return __libc_malloc(bytes);
}
