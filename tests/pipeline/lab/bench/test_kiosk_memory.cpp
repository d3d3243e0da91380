#include <gtest/gtest.h>

#include "pipeline/lab/bench/kiosk_memory.hpp"

namespace kasumi {
namespace {

// Three mappings: memory without a file, the GL driver's library of which the process has written a page, another file.
TEST(KioskMemory, IsReadFromTheKernelsList) {
  const auto memory = resident_memory(
      "7f00-7f10 rw-p 00000000 00:00 0 \nSize: 100 kB\nRss:                  80 kB\nAnonymous:            80 kB\n"
      "VmFlags: rd wr mr mw me ac \n"
      "7f10-7f20 r-xp 00000000 fe:00 77   /usr/lib/x86_64-linux-gnu/libLLVM-15.so.1\n"
      "Size: 900 kB\nRss:   50 kB\nAnonymous:   4 kB\n"
      "7f20-7f30 r-xp 00000000 fe:00 78   /usr/bin/kasumi\nSize: 40 kB\nRss: 7 kB\nAnonymous: 0 kB\n");
  EXPECT_DOUBLE_EQ(memory.all_kb, 137.0);
  EXPECT_DOUBLE_EQ(memory.own_kb, 84.0);
  EXPECT_DOUBLE_EQ(memory.gl_files_kb, 46.0);
}

}  // namespace
}  // namespace kasumi
