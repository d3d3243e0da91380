// What `kasumi estimate` is given: picture files, folders and archives of them, recordings, lists and patterns, mixed, as one stream
// of pictures in the order given.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/archive/archive_record.hpp"
#include "pipeline/lab/photographs/calibration_periods.hpp"
#include "pipeline/lab/photographs/estimate_request.hpp"

namespace kasumi {

struct EstimateInput {
  std::filesystem::path file;
  std::optional<Utc> utc;
  std::string problem;     // with its line of a list, or its row of a recording; the file is not read then
  std::size_t camera = 0;  // in EstimateInputs::cameras
  std::string label{};     // of a list's line: the kind of air by its writer, a class of its own for `kasumi prove`
};

// Pictures that may be exposures of one sky: of one folder and camera, each at most kStackWithin after the one before.
constexpr std::chrono::seconds kStackWithin{5};
constexpr std::size_t kMostInStack = 9;  // more in a row are a series

struct PictureStack {
  std::vector<EstimateInput> pictures;  // one: it stands by itself
  std::size_t first = 0, count = 1;     // those of them that are to be answered; the others are another shard's
};

// One line of a list: a path, or a path, a tab and a UTC time, or these, a tab and a label.
EstimateInput input_of_line(std::string line);

class EstimateInputs {
 public:
  // Expands arguments.images; standard input is read when its turn comes. Folders give the pictures in them, by name,
  // without those of --plot; tar and zip files theirs, in their order; folders with fixture.toml the frames of their sky camera, under their own camera and site
  // unless a --calibration is given. Errors (bad_input): all of the options for pictures of the command line's camera.
  static Result<EstimateInputs> expand(const EstimateRequest& arguments);

  // Arguments that give no picture: "x.png: no such file or folder". The other arguments are not affected.
  const Problems& problems() const { return problems_; }
  bool empty() const { return inputs_.empty(); }
  // How many pictures; empty: that is known when standard input has ended.
  std::optional<std::size_t> count() const;
  // Not thread-safe.
  std::optional<EstimateInput> next();
  // The next pictures, at most so many, without taking them. Of standard input only the lines that are available, so
  // that a program that writes one and waits for its answer does not wait for ever.
  std::vector<EstimateInput> ahead(std::size_t most);
  // All that are left, without taking them; waits for the end of standard input.
  std::vector<EstimateInput> all();
  // Waits for the end of standard input, so that the list is whole.
  void complete();
  // Adds names and times of the whole list, in order. After complete().
  void add_to(Fingerprint& fingerprint) const;
  // Leaves out all but so many. After complete(), before any is taken. Afterwards next_stack() takes them.
  void keep(std::size_t first, std::size_t count);
  // The next pictures that may be one stack, also with those that were left out: so that a stack is the same whatever
  // shards it is cut into. Not thread-safe.
  std::optional<PictureStack> next_stack();
  // At most so many, spread over the list and, where its pictures follow each other evenly, over day and year; in the
  // list's order, which archives are read in. After complete().
  std::vector<EstimateInput> sample(std::size_t most) const;
  // The first is the command line's; the others are --camera's and recordings'.
  const std::vector<PhotographSetup>& cameras() const { return cameras_; }
  void set_tone(const ToneCurve& tone) { cameras_.front().tone = tone; }
  void set_memory(const std::shared_ptr<const CameraMemory>& memory) {
    for (auto& camera : cameras_) camera.memory = memory;
  }

 private:
  // Small, since a list may have a million: its lines are taken apart when their turn comes.
  struct Entry {
    std::unique_ptr<EstimateInput> input;  // null: a line of a list, or standard input, where a list is read
    const std::string* lines = nullptr;    // of the list
    std::size_t begin = 0, length = 0;
    bool standard_input() const { return !input && !lines; }
  };
  void add(EstimateInput input) { inputs_.push_back({std::make_unique<EstimateInput>(std::move(input))}); }
  // Adds the lines of a list that are not empty.
  void add_lines(std::string text, std::vector<Entry>& entries);
  static EstimateInput input_of(const Entry& entry);
  void add(const EstimateRequest& arguments, const std::string& word);
  void add_path(const EstimateRequest& arguments, const std::filesystem::path& path);
  void add_pattern(const EstimateRequest& arguments, const std::string& pattern);
  void add_list(const std::filesystem::path& file);
  void add_members(const std::filesystem::path& archive);
  void add_folder(const std::filesystem::path& folder);
  void add_recording(const EstimateRequest& arguments, const std::filesystem::path& folder);

  Result<> read_cameras(const EstimateRequest& arguments);
  std::optional<EstimateInput> take(bool wait);
  EstimateInput timed(EstimateInput input) const;
  const EstimateInput& timed_at(std::size_t entry);
  bool may_follow(std::size_t entry);  // the one before as an exposure of one stack

  std::vector<Entry> inputs_;
  std::deque<std::unique_ptr<const std::string>> lists_;
  std::size_t at_ = 0;
  std::size_t end_ = 0;                         // of those that are kept
  std::map<std::size_t, EstimateInput> timed_;  // around at_, by entry
  std::deque<EstimateInput> ahead_;             // taken from inputs_, not yet by next()
  std::vector<PhotographSetup> cameras_{PhotographSetup{}};
  CalibrationPeriods periods_;        // of --camera
  std::size_t first_of_periods_ = 0;  // in cameras_
  bool of_command_line_ = false;      // pictures need the camera of the command line
  std::optional<PictureTimes> times_;
  Problems problems_;
};

}  // namespace kasumi
