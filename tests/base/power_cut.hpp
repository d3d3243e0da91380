// A disk that a power cut may take everything from that was not written through. Linked into a test program, it stands
// before the C library's calls that change files; they do what they always do and are noted.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

namespace kasumi {

class PowerCut {
 public:
  // What lies in the folder now is on the disk. One at a time.
  explicit PowerCut(std::filesystem::path folder);
  ~PowerCut();
  PowerCut(const PowerCut&) = delete;
  PowerCut& operator=(const PowerCut&) = delete;

  // Calls so far that changed something below the folder, or wrote it through.
  std::size_t calls() const;

  // The system writes names and contents when it likes and in any order: of what was not written through, a cut may
  // have left these.
  enum class Left { nothing, names, contents, names_and_contents };
  static constexpr Left kAll[] = {Left::nothing, Left::names, Left::contents, Left::names_and_contents};
  // Puts into `to`, which is emptied, what the folder holds after a cut that came when so many calls had returned.
  void lay_out(std::size_t calls, Left left, const std::filesystem::path& to) const;

  struct Notes;

 private:
  std::unique_ptr<Notes> notes_;
};

}  // namespace kasumi
