// Where pictures come from, one at a time: files, folders of them, films.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

struct NamedPicture {
  std::string name;  // "land/hazy.png", "land/hazy.mp4, frame 12"
  std::string stem;  // "hazy", "hazy.frame-000012"
  Photograph photograph;
  std::string damage;  // of a file, where that is allowed; empty: none
};

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // The next picture; empty after the last. Only one is in memory at a time. Errors: bad_input.
  virtual Result<std::optional<NamedPicture>> next() = 0;
  // Of a film as its file says; empty where there is none.
  virtual std::optional<double> frames_per_second() const { return std::nullopt; }
  // Whether the pictures are consecutive in time: a film or a folder.
  virtual bool is_sequence() const { return false; }
};

// By the ending of its name, in capitals or not.
bool is_picture_file(const std::filesystem::path& path);
// The picture files of a folder, sorted by name; not those of its folders. None: there are none, or it cannot be read.
std::vector<std::filesystem::path> pictures_in(const std::filesystem::path& folder);

// Each of `names` a picture, a folder (its pictures by name) or a film (what this machine's FFmpeg reads: .mp4, .mov,
// .mkv, .avi, .webm); a film or a folder must be the only one. Errors (bad_input): nothing there, an empty folder. `allow_damaged`:
// of files, what is left of them; else next() refuses them.
Result<std::unique_ptr<PictureSource>> open_pictures(const std::vector<std::string>& names, bool allow_damaged = false);

}  // namespace kasumi
