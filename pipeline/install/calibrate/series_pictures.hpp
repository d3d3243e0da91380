// Pictures of the sky by one camera that stands still, with their times, of which nothing else is known.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "calib/mask/image_circle.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_times.hpp"

namespace kasumi {

// The brighter of both, pixel by pixel; an empty one becomes the other. Both of one size.
void keep_brightest(Image<Rgb8>& brightest, const Image<Rgb8>& picture);

struct SeriesFile {
  std::filesystem::path file;
  Utc utc{};
};

struct SeriesPictures {
  std::vector<SeriesFile> pictures;  // readable, with a time, of the size that most have; in order of time
  int width = 0, height = 0;
  int without_time = 0, unreadable = 0, of_other_size = 0;
  Image<Rgb8> brightest;  // over all pictures: shows the rim wherever it was lit at least once
  FoundCircle circle;     // that most pictures show
};

// `what`: a folder, a list, a pattern or pictures, as `kasumi estimate` takes them. `circle`: given, or to be found.
// Errors (bad_input): nothing there, no picture with a time, no image circle; with what is expected.
Result<SeriesPictures> read_series(const std::vector<std::string>& what, const PictureTimes& times,
                                   const std::optional<ImageCircle>& circle);

// Each picture with square pixels, at most so many, spread over the series.
void for_each_of(const SeriesPictures& series, std::size_t most,
                 const std::function<void(const SeriesFile&, Photograph&)>& use);

}  // namespace kasumi
