#include "pipeline/lab/haze/retarget_outputs.hpp"

#include <cstdio>

namespace kasumi {
namespace {

// `old`: what it was called when its name did not say that it is a mask; a link, or a copy where there are no links.
Result<> write_mask(const std::filesystem::path& path, const std::filesystem::path& old,
                    const Image<std::uint8_t>& mask) {
  Image<Rgb8> picture(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.elements().size(); ++i) picture.elements()[i] = Rgb8(mask.elements()[i]);
  if (auto written = write_png(path, picture); !written) return written;
  std::error_code error;
  std::filesystem::remove(old, error);
  std::filesystem::create_symlink(path.filename(), old, error);
  return error ? write_png(old, picture) : Result<>{};
}

}  // namespace

Result<RetargetOutputs> RetargetOutputs::open(const RetargetRequest& a, const std::vector<std::string>& targets,
                                              const PictureSource& source) {
  RetargetOutputs outputs;
  outputs.out_ = a.out;
  outputs.sheet_file_ = a.sheet;
  outputs.targets_ = targets;
  outputs.single_ = a.pictures.size() == 1 && targets.size() == 1 && !source.is_sequence();
  outputs.prints_ = !source.is_sequence();
  if (source.is_sequence() && !a.sheet.empty())
    return fail(FaultKind::bad_input,
                "--sheet {}: expected pictures, not a film or a folder: a sheet keeps all of them in memory", a.sheet);
  if (!outputs.single_ && !a.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(a.out, error);
    if (error)
      return fail(FaultKind::bad_input, "--out {}: expected a folder, for several pictures ({})", a.out,
                  error.message());
  }
  if (a.film.empty()) return outputs;
  const double frames_per_second = a.frames_per_second.value_or(source.frames_per_second().value_or(10.0));
  const bool one = !source.is_sequence() || targets.size() == 1;
  const std::filesystem::path film = a.film;
  for (std::size_t i = 0; i < (one ? 1 : targets.size()); ++i) {
    const auto name =
        one ? film
            : film.parent_path() / fmt::format("{}.{}{}", film.stem().string(), targets[i], film.extension().string());
    auto opened = open_film(name, frames_per_second);
    if (!opened) return fail(opened.error());
    outputs.films_.push_back(std::move(*opened));
  }
  return outputs;
}

// OUT itself for one picture under one air; else OUT/NAME.T2.50.png.
std::filesystem::path RetargetOutputs::path_of(const std::string& stem, std::size_t target) const {
  return single_ ? out_ : out_ / fmt::format("{}.{}.png", stem, targets_[target]);
}

void RetargetOutputs::as_taken(const Photograph& photograph) {
  origin_ = photograph.origin;
  if (!sheet_file_.empty()) sheet_.add(to_rgb8(photograph), "as taken");
}

Result<> RetargetOutputs::put(const std::string& stem, std::size_t target, const UnderOtherAir& made) {
  if (!out_.empty()) {
    const auto place = path_of(stem, target);
    const auto beside = [&](const char* ending) { return std::filesystem::path(place).replace_extension(ending); };
    auto picture = made.picture;
    picture.origin = origin_;
    if (auto done = write_photograph(place, picture); !done) return done;
    if (auto done = write_mask(beside(".restored-mask.png"), beside(".restored.png"), made.restored); !done)
      return done;
    if (made.airlight)
      if (auto done = write_photograph(beside(".airlight.png"), *made.airlight); !done) return done;
    if (made.direct)
      if (auto done = write_photograph(beside(".direct.png"), *made.direct); !done) return done;
    if (prints_)
      fmt::print("{}: {}, {:.1f} % too faint to restore\n", place.string(), targets_[target],
                 100.0 * made.too_faint_fraction);
  }
  if (sheet_file_.empty() && films_.empty()) return {};
  const auto pixels = to_rgb8(made.picture);
  if (!sheet_file_.empty()) sheet_.add(pixels, targets_[target]);
  return films_.empty() ? Result<>{} : films_[films_.size() == 1 ? 0 : target]->put(pixels);
}

Result<> RetargetOutputs::finish() {
  for (const auto& film : films_)
    if (auto done = film->finish(); !done) return done;
  return sheet_file_.empty() ? Result<>{} : sheet_.write(sheet_file_);
}

}  // namespace kasumi
