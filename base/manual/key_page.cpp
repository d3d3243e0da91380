#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "base/manual/manual.hpp"
#include "base/manual/roff.hpp"

namespace kasumi {

namespace {

std::string trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

// A value and the comment behind it; a # within quotes is none.
struct Explained {
  std::string value, comment;
};
Explained explained(std::string_view text) {
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    if (text[i] == '#' && !quoted) return {trim(text.substr(0, i)), trim(text.substr(i + 1))};
  }
  return {trim(text), {}};
}

class KeyPage {
 public:
  void read(const std::string& line) {
    static const std::regex heading(R"(# -+ (.*) -+)"), table(R"((?:# )?(\[\[?[a-z_.]+\]\]?)(.*))"),
        key(R"((#? ?)([a-z0-9_]+) = (.*))"), more(R"(\s+# ?(.*))");
    std::smatch match;
    if (line.empty()) {
      end_paragraph();
    } else if (std::regex_match(line, match, heading)) {
      end_paragraph();
      page_ += ".SH " + roff(trim(match[1].str())) + "\n";
    } else if (std::regex_match(line, match, table)) {
      auto before = std::exchange(words_, {});
      page_ += ".SS " + roff(match[1].str()) + "\n";
      say(trim(before + " " + explained(match[2].str()).comment));
    } else if (std::regex_match(line, match, key)) {
      end_paragraph();
      const auto is = explained(match[3].str());
      const auto mark = match[1].str();
      page_ += fmt::format(".TP\n\\fB{}\\fR = {}{}\n", roff(match[2].str()), roff(is.value),
                           mark == "#"    ? " (default)"
                           : mark == "# " ? " (example; no default)"
                                          : " (example)");
      say(is.comment);
    } else if (std::regex_match(line, match, more)) {
      say(trim(match[1].str()));
    } else if (line.starts_with('#')) {
      words_ += (words_.empty() ? "" : " ") + trim(line.substr(1));
    }
  }
  std::string text() {
    end_paragraph();
    return page_;
  }

 private:
  void say(const std::string& words) {
    if (!words.empty()) page_ += roff(words) + "\n";
  }
  void end_paragraph() {
    const auto words = std::exchange(words_, {});
    if (!words.empty()) page_ += ".PP\n" + roff(words) + "\n";
  }
  std::string page_, words_;
};

}  // namespace

std::string key_page(std::string_view example, std::string_view name, std::string_view version) {
  std::string title(name);
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string page = fmt::format(".TH {} 5 \"\" \"kasumi {}\" \"File Formats\"\n.SH NAME\n", title, version);
  std::istringstream lines{std::string(example)};
  KeyPage keys;
  std::string line;
  // "# kasumi.toml: one kiosk. Copy it ...": the name and what it is.
  if (std::getline(lines, line)) {
    const auto colon = line.find(": "), stop = line.find(". ", colon);
    const bool named = colon != std::string::npos && stop != std::string::npos;
    page += fmt::format("{} \\- {}\n.SH DESCRIPTION\n", roff(name),
                        named ? roff(line.substr(colon + 2, stop - colon - 2)) : "configuration");
    if (named) keys.read("# " + line.substr(stop + 2));
  }
  while (std::getline(lines, line)) keys.read(line);
  return page + keys.text() + ".SH SEE ALSO\n.BR kasumi (1)\n.PP\n" +
         "The whole file: /usr/share/doc/kasumi/examples/kasumi.toml\n";
}

}  // namespace kasumi
