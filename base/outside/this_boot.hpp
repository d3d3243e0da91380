// This boot of the machine.
#pragma once

#include <string>

namespace kasumi {

std::string boot_id();  // the kernel's; empty: unknown
double since_boot_s();  // time asleep included

}  // namespace kasumi
