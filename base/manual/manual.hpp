// A program's manual page and its completion, made from its own command line, so that there is no second text to go
// stale.
#pragma once

#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace kasumi {

// man(7), section 1: every command with its options, in the order of --help.
std::string manual_page(const CLI::App& app, std::string_view version);

// A bash function: commands, options, the words that an option takes, files elsewhere.
std::string bash_completion(const CLI::App& app);

// man(7), section 5, of a configuration that explains itself (systemd/kasumi.toml): the comment on top, then its tables
// and keys. `#key = value` is a default, `# key = value` a key without one, `key = value` one that must be there.
std::string key_page(std::string_view example, std::string_view name, std::string_view version);

// For a refused command line: "did you mean --turbidity?\n", from commands, options and the words an option takes;
// empty: nothing similar.
std::string meant_instead(const CLI::App& app, const std::string& refusal, int argc, char** argv);

// `--manual page`, `--manual bash`, or `--manual keys` with an example on standard input, printed for the build: false:
// something else was asked for.
bool print_manual(const CLI::App& app, std::string_view version, int argc, char** argv);

}  // namespace kasumi
