// Pages of the program's file and of its libraries' that lie in this process.
#pragma once

namespace kasumi {

// Takes all code and constants out of this process. What is used comes back at its next use, out of the kernel's memory
// while they lie there, else from the disk; what a start alone needed stays away, a compiler of shaders first of all, and
// the kernel takes its place first where memory is short. A debugger's breakpoints go, too. Thread-safe.
void let_code_go();

}  // namespace kasumi
