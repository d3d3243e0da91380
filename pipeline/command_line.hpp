// The whole command line of `kasumi`.
#pragma once

#include <memory>

#include "pipeline/command.hpp"

namespace kasumi {

// All commands with their options. Parsing sets `action`, which must outlive it, to what the chosen one does.
std::unique_ptr<CLI::App> command_line(Action& action);

}  // namespace kasumi
