// Numbers on a command line are finite.
#pragma once

namespace CLI {
class App;
}

namespace kasumi {

// Every option of `app` and of its subcommands that takes numbers refuses nan, inf and what is too large for a double,
// after its own checks: nan is neither below a range nor above it, so that CLI::Range lets it pass. To be called when
// all options are there. Options of text, whose readers check for themselves, are left alone.
void refuse_infinite_numbers(CLI::App& app);

}  // namespace kasumi
