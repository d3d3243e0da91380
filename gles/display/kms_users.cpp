// Which processes have a card open, as far as the kernel permits this user to see.
#include <algorithm>
#include <fstream>
#include <sstream>

#include <unistd.h>

#include "gles/display/kms_system.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 10 && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// Process ids of masters from <debug>/dri/<number>/clients, one client per line: "command tgid dev master a uid magic".
std::vector<int> masters(const fs::path& card, const fs::path& debug) {
  std::vector<int> found;
  const std::string name = card.filename().string();
  if (!name.starts_with("card")) return found;
  std::ifstream clients(debug / "dri" / name.substr(4) / "clients");
  std::string line;
  std::getline(clients, line);  // the heading
  while (std::getline(clients, line)) {
    // The command may contain spaces, so fields are read from the end.
    std::istringstream words(line);
    std::vector<std::string> fields;
    for (std::string word; words >> word;) fields.push_back(word);
    if (fields.size() >= 7 && fields[fields.size() - 4] == "y" && is_number(fields[fields.size() - 6]))
      found.push_back(std::stoi(fields[fields.size() - 6]));
  }
  return found;
}

bool has_open(const fs::path& process, const fs::path& card) {
  std::error_code error;
  for (fs::directory_iterator fd(process / "fd", error), end; !error && fd != end; fd.increment(error)) {
    std::error_code unreadable;
    if (fs::read_symlink(fd->path(), unreadable) == card) return true;
  }
  return false;
}

}  // namespace

std::string card_users(const std::string& path, const fs::path& proc, const fs::path& debug) {
  std::error_code error;
  fs::path card = fs::canonical(path, error);
  if (error) card = path;
  std::vector<int> known = masters(card, debug);
  const std::size_t masters_known = known.size();
  for (fs::directory_iterator process(proc, error), end; !error && process != end; process.increment(error)) {
    const std::string name = process->path().filename().string();
    if (!is_number(name)) continue;
    const int pid = std::stoi(name);
    if (pid != getpid() && std::ranges::find(known, pid) == known.end() && has_open(process->path(), card))
      known.push_back(pid);
  }
  std::string words;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i] == getpid()) continue;
    const std::string command = first_line(proc / std::to_string(known[i]) / "comm");
    words += fmt::format("{}{} (pid {}) {}", words.empty() ? "" : ", ", command.empty() ? "a process" : command,
                         known[i], i < masters_known ? "is master" : "has it open");
  }
  return words;
}

}  // namespace kasumi
