#include "pipeline/lab/photographs/estimate_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <numbers>
#include <set>

#include <glob.h>
#include <poll.h>
#include <unistd.h>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "capture/fixture/fixture.hpp"
#include "pipeline/site/files/archive_members.hpp"
#include "pipeline/site/files/picture_source.hpp"

namespace kasumi {
namespace {

constexpr const char* kFixtureFile = "fixture.toml";

bool is_folder(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}
bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}
// --plot writes IMAGE.fit.png beside its image; some systems and programs leave hidden files that are named as pictures.
bool is_sky_picture(const std::filesystem::path& path) {
  const auto name = path.filename().string();
  return is_picture_file(path) && !name.starts_with(".") && !name.ends_with(".fit.png");
}

// Whether standard input has more, or ends, within a moment; std::cin reads ahead, so its buffer is checked first.
bool line_is_there() {
  constexpr int kMoment_ms = 50;
  if (std::cin.rdbuf()->in_avail() > 0) return true;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return ::poll(&input, 1, kMoment_ms) > 0;
}

}  // namespace

EstimateInput input_of_line(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  EstimateInput input;
  const auto tab = line.find('\t');
  input.file = line.substr(0, tab);
  if (tab == std::string::npos) return input;
  const auto second = line.find('\t', tab + 1);
  const auto time = line.substr(tab + 1, second == std::string::npos ? second : second - tab - 1);
  if (second != std::string::npos) input.label = line.substr(second + 1);
  input.utc = parse_utc(time);
  if (!input.utc)
    input.problem = fmt::format("{}: time '{}': expected a time like 2018-01-29T11:09:20Z", input.file.string(), time);
  return input;
}

Result<EstimateInputs> EstimateInputs::expand(const EstimateRequest& arguments) {
  EstimateInputs inputs;
  if (auto read = inputs.read_cameras(arguments); !read) return fail(read.error());
  if (!arguments.time_format.empty())
    inputs.times_ = PictureTimes{arguments.time_format == "auto" ? "" : arguments.time_format, arguments.utc_offset_h};
  if (arguments.images.empty())
    inputs.add(arguments, "-");
  else
    for (const auto& word : arguments.images) inputs.add(arguments, word);
  if (inputs.of_command_line_) {
    auto options = photograph_setup(arguments);
    if (!options) return fail(options.error());
    inputs.cameras_.front() = std::move(*options);
  }
  return inputs;
}

void EstimateInputs::add(const EstimateRequest& arguments, const std::string& word) {
  if (word == "-") {
    if (std::ranges::any_of(inputs_, &Entry::standard_input)) {
      problems_.add("-: given twice, expected standard input once");
      return;
    }
    of_command_line_ = true;
    std::ios::sync_with_stdio(false);  // else available lines cannot be counted
    inputs_.emplace_back();
  } else if (is_there(word)) {
    add_path(arguments, word);
  } else if (const auto member = archive_member(word); member && is_there(member->archive)) {
    of_command_line_ = true;
    add(EstimateInput{word, {}, {}, 0});
  } else if (word.starts_with("@")) {
    add_list(word.substr(1));
  } else if (word.find_first_of("*?[") != std::string::npos) {
    add_pattern(arguments, word);
  } else {
    problems_.add("{}: no such file or folder", word);
  }
}

void EstimateInputs::add_path(const EstimateRequest& arguments, const std::filesystem::path& path) {
  if (!is_folder(path)) {
    if (is_archive_file(path)) return add_members(path);
    of_command_line_ = true;
    add(EstimateInput{path, {}, {}, 0});
  } else if (is_there(path / kFixtureFile)) {
    add_recording(arguments, path);
  } else {
    add_folder(path);
  }
}

void EstimateInputs::add_pattern(const EstimateRequest& arguments, const std::string& pattern) {
  glob_t matches{};
  const bool any = ::glob(pattern.c_str(), 0, nullptr, &matches) == 0;
  if (!any) problems_.add("{}: no file matches", pattern);
  for (std::size_t i = 0; any && i < matches.gl_pathc; ++i) add_path(arguments, matches.gl_pathv[i]);
  ::globfree(&matches);
}

void EstimateInputs::add_list(const std::filesystem::path& file) {
  auto text = is_folder(file) ? fail(FaultKind::bad_input, "{}: expected a list, not a folder", file.string())
                              : read_text_file(file, {.or_pipe = true});
  if (!text) {
    problems_.add("@{}", text.error().message);
    return;
  }
  const auto before = inputs_.size();
  add_lines(std::move(*text), inputs_);
  if (inputs_.size() == before) problems_.add("@{}: an empty list, expected one path a line", file.string());
  of_command_line_ = of_command_line_ || inputs_.size() > before;
}

void EstimateInputs::add_folder(const std::filesystem::path& folder) {
  auto files = pictures_in(folder);
  std::erase_if(files, [](const auto& file) { return !is_sky_picture(file); });
  if (files.empty()) problems_.add("{}: a folder without any picture", folder.string());
  for (auto& file : files) add(EstimateInput{std::move(file), {}, {}, 0});
  of_command_line_ = of_command_line_ || !files.empty();
}

// Their names are kept as lines of a list.
void EstimateInputs::add_members(const std::filesystem::path& archive) {
  auto names = members_of(archive);
  if (!names) {
    problems_.add("{}", names.error().message);
    return;
  }
  std::erase_if(*names, [](const auto& name) { return !is_sky_picture(name); });
  if (names->empty()) problems_.add("{}: an archive without any picture", archive.string());
  std::set<std::string_view> once;
  std::string lines;
  for (const auto& name : *names) {
    const bool again = !once.insert(name).second, broken = name.find_first_of("\t\r\n") != std::string::npos;
    if (again || broken) {
      problems_.add("{}: {}: {}", archive.string(), name,
                    again ? "is there twice, expected each name once" : "has a tab or a line break in its name");
      return;
    }
    lines += ArchiveMember{archive, name}.path().native() + '\n';
  }
  add_lines(std::move(lines), inputs_);
  of_command_line_ = of_command_line_ || !names->empty();
}

void EstimateInputs::add_recording(const EstimateRequest& arguments, const std::filesystem::path& folder) {
  const auto rows = read_index(folder / "sky");
  if (!rows) {
    problems_.add("{}", rows.error().message);
    return;
  }
  std::size_t camera = 0;
  if (arguments.calibration.empty()) {
    auto own = arguments;
    own.calibration = (folder / kFixtureFile).string();
    auto options = photograph_setup(own);
    if (!options) {
      problems_.add("{}: {}", folder.string(), options.error().message);
      return;
    }
    camera = cameras_.size();
    cameras_.push_back(std::move(*options));
  }
  const auto before = inputs_.size();
  for (const auto& row : *rows) {
    if (row.disconnected) continue;
    EstimateInput input{folder / "sky" / row.payload, row.metadata.utc, {}, camera};
    if (row.payload.empty() || row.metadata.format != kMjpg) {
      problems_.add("{}: its sky camera recorded {}, expected JPEG files: kasumi replay reads it", folder.string(),
                    row.metadata.format.text());
      inputs_.resize(before);
      return;
    }
    if (row.metadata.status == FrameStatus::flagged && !arguments.allow_damaged)
      input.problem = fmt::format("{}: the camera's driver says that it is damaged", input.file.string());
    add(std::move(input));
  }
  if (inputs_.size() == before) problems_.add("{}: a recording without any picture of the sky", folder.string());
  of_command_line_ = of_command_line_ || (camera == 0 && inputs_.size() > before);
}

std::optional<std::size_t> EstimateInputs::count() const {
  if (std::ranges::any_of(inputs_, &Entry::standard_input)) return std::nullopt;
  return inputs_.size();
}

std::optional<EstimateInput> EstimateInputs::take(bool wait) {
  while (at_ < inputs_.size()) {
    if (!inputs_[at_].standard_input()) return input_of(inputs_[at_++]);
    if (!wait && !line_is_there()) return std::nullopt;
    std::string line;
    if (!std::getline(std::cin, line))
      ++at_;
    else if (!line.empty() && line != "\r")
      return input_of_line(std::move(line));
  }
  return std::nullopt;
}

std::optional<EstimateInput> EstimateInputs::next() {
  if (ahead_.empty()) {
    auto input = take(true);
    return input ? std::optional(timed(std::move(*input))) : std::nullopt;
  }
  auto first = std::move(ahead_.front());
  ahead_.pop_front();
  return first;
}

std::vector<EstimateInput> EstimateInputs::ahead(std::size_t most) {
  while (ahead_.size() < most) {
    auto input = take(false);
    if (!input) break;
    ahead_.push_back(timed(std::move(*input)));
  }
  return {ahead_.begin(), ahead_.begin() + static_cast<std::ptrdiff_t>(std::min(most, ahead_.size()))};
}

std::vector<EstimateInput> EstimateInputs::all() {
  while (auto input = take(true)) ahead_.push_back(timed(std::move(*input)));
  return {ahead_.begin(), ahead_.end()};
}

EstimateInput EstimateInputs::timed(EstimateInput input) const {
  if (!input.problem.empty()) return input;
  if (times_ && !input.utc) {
    input.utc = picture_time(input.file, *times_);
    if (!input.utc && !cameras_[input.camera].utc)
      input.problem = fmt::format(
          "{}: no time {}", input.file.string(),
          times_->format.empty() ? "in its name or in EXIF" : fmt::format("like {} in its name", times_->format));
  }
  if (periods_.empty() || input.camera != 0 || !input.problem.empty()) return input;
  const auto utc = input.utc ? input.utc : cameras_.front().utc;
  if (const auto period = utc ? periods_.at(*utc) : std::nullopt)
    input.camera = first_of_periods_ + *period;
  else
    input.problem =
        fmt::format("{}: {}", input.file.string(),
                    utc ? "no --camera is of " + utc_text(*utc) : "no time, by which its --camera is known");
  return input;
}

Result<> EstimateInputs::read_cameras(const EstimateRequest& arguments) {
  auto periods = CalibrationPeriods::read(arguments.cameras);
  if (!periods) return fail(periods.error());
  periods_ = std::move(*periods);
  if (periods_.empty()) return {};
  Problems problems;
  if (!arguments.calibration.empty() || !arguments.camera_memory.empty())
    problems.add(
        "--camera: has the camera of each picture, expected neither --calibration nor --camera-memory beside it");
  first_of_periods_ = cameras_.size();
  for (std::size_t i = 0; i < periods_.size() && problems.empty(); ++i) {
    auto own = arguments;
    own.calibration = periods_.file(i);
    auto options = photograph_setup(own);
    if (!options) return fail(FaultKind::bad_input, "--camera {}: {}", periods_.file(i), options.error().message);
    cameras_.push_back(std::move(*options));
  }
  return problems.empty() ? Result<>() : fail(problems.fault());
}

void EstimateInputs::add_lines(std::string text, std::vector<Entry>& entries) {
  const auto& list = *lists_.emplace_back(std::make_unique<const std::string>(std::move(text)));
  for (std::size_t begin = 0; begin < list.size();) {
    const auto end = std::min(list.find('\n', begin), list.size());
    if (end > begin && list.compare(begin, end - begin, "\r") != 0)
      entries.push_back({nullptr, &list, begin, end - begin});
    begin = end + 1;
  }
}

EstimateInput EstimateInputs::input_of(const Entry& entry) {
  return entry.input ? *entry.input : input_of_line(entry.lines->substr(entry.begin, entry.length));
}

void EstimateInputs::complete() {
  if (count()) return;
  std::vector<Entry> whole;
  for (auto& entry : inputs_) {
    if (!entry.standard_input()) {
      whole.push_back(std::move(entry));
      continue;
    }
    std::string text;
    for (std::string line; std::getline(std::cin, line);) text += line + '\n';
    add_lines(std::move(text), whole);
  }
  inputs_ = std::move(whole);
}

void EstimateInputs::add_to(Fingerprint& fingerprint) const {
  for (const auto& entry : inputs_) {
    const auto input = input_of(entry);
    fingerprint.add(input.file.native());
    fingerprint.add(input.utc ? utc_text(*input.utc) : "");
  }
}

void EstimateInputs::keep(std::size_t first, std::size_t count) {
  const auto from = first - std::min(first, kMostInStack), to = std::min(inputs_.size(), first + count + kMostInStack);
  std::vector<Entry> kept(std::make_move_iterator(inputs_.begin() + static_cast<std::ptrdiff_t>(from)),
                          std::make_move_iterator(inputs_.begin() + static_cast<std::ptrdiff_t>(to)));
  inputs_ = std::move(kept);
  at_ = first - from;
  end_ = at_ + count;
}

const EstimateInput& EstimateInputs::timed_at(std::size_t entry) {
  const auto before = timed_.find(entry);
  return before != timed_.end() ? before->second : timed_.emplace(entry, timed(input_of(inputs_[entry]))).first->second;
}

bool EstimateInputs::may_follow(std::size_t entry) {
  const auto &a = timed_at(entry - 1), &b = timed_at(entry);
  return a.problem.empty() && b.problem.empty() && a.camera == b.camera && a.utc && b.utc && *a.utc <= *b.utc &&
         *b.utc - *a.utc <= kStackWithin && a.file.parent_path() == b.file.parent_path();
}

std::optional<PictureStack> EstimateInputs::next_stack() {
  if (at_ == end_) return std::nullopt;
  timed_.erase(timed_.begin(), timed_.lower_bound(at_ - std::min(at_, kMostInStack + 1)));
  std::size_t first = at_, last = at_;
  while (first > 0 && at_ - first < kMostInStack && may_follow(first)) --first;
  while (last + 1 < inputs_.size() && last - first < kMostInStack && may_follow(last + 1)) ++last;
  if (last - first >= kMostInStack) first = last = at_;
  PictureStack stack;
  for (std::size_t i = first; i <= last; ++i) stack.pictures.push_back(timed_at(i));
  stack.first = at_ - first;
  at_ = std::min(last + 1, end_);
  stack.count = at_ - first - stack.first;
  return stack;
}

// Even steps would meet one hour of the day again and again.
std::vector<EstimateInput> EstimateInputs::sample(std::size_t most) const {
  std::set<std::size_t> taken;
  const auto count = static_cast<double>(inputs_.size());
  for (std::size_t k = 0; taken.size() < std::min(most, inputs_.size()); ++k) {
    const double share = std::fmod(static_cast<double>(k) * std::numbers::phi, 1.0);
    taken.insert(std::min(inputs_.size() - 1, static_cast<std::size_t>(share * count)));
  }
  std::vector<EstimateInput> some;
  for (const auto at : taken) some.push_back(timed(input_of(inputs_[at])));
  return some;
}

}  // namespace kasumi
