// What every fuzzer has in common: no input may take longer than this of the processor's time. libFuzzer's own -timeout is of
// the clock on the wall, which other programs share.
#include <cstdlib>

#include <signal.h>
#include <sys/time.h>

#include "tests/fuzz/scratch.hpp"

namespace {

constexpr time_t kLongest_s = 5;

void give_it(time_t seconds) {
  const itimerval limit{{}, {seconds, 0}};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool listening =
      ::signal(SIGPROF, [](int) { std::abort(); }) != SIG_ERR;  // libFuzzer shows where it was
  if (!listening) std::abort();
  give_it(kLongest_s);
  kasumi::try_input({data, size});
  give_it(0);
  return 0;
}
