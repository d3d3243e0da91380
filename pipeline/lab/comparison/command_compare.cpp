#include <algorithm>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/comparison/pixel_errors.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

struct ComparisonRequest {
  std::string one, other, mask;
  bool json = false;
};

struct ComparedPictures {
  std::optional<double> ssim;
  HsvCorrelation hsv;
  PixelErrors errors;
};

Result<Photograph> read_whole_numbers(const std::string& file) {
  auto photograph = read_photograph(file);
  if (photograph && photograph->quantum == 0.0)
    return fail(FaultKind::bad_input,
                "{}: floating point has no white to compare against: expected a picture of 8 or 16 bits", file);
  return photograph;
}

Result<> same_size(const std::string& file, const Photograph& picture, const std::string& as, const Photograph& like) {
  const auto &is = picture.encoded, &other = like.encoded;
  if (is.width() == other.width() && is.height() == other.height()) return {};
  return fail(FaultKind::bad_input, "{}: is {} x {}: expected {} x {}, as {} is", file, is.width(), is.height(),
              other.width(), other.height(), as);
}

// White counts, black does not; between them a mask that was scaled or compressed counts where it is the brighter.
CountedPixels counted_in(const Photograph& mask) {
  CountedPixels counted(mask.encoded.width(), mask.encoded.height());
  for (std::size_t i = 0; i < counted.elements().size(); ++i)
    counted.elements()[i] =
        mask.encoded.elements()[i].g >= 0.5F && (mask.opacity.empty() || mask.opacity.elements()[i] >= 0.5F) ? 255 : 0;
  return counted;
}

std::string text_of(const ComparedPictures& is) {
  const auto& difference = is.errors.ciede2000;
  return fmt::format(
      "pixels           {}\n"
      "SSIM             {}\n"
      "HSV correlation  {:.4f} (hue {:.4f}, saturation {:.4f}, value {:.4f})\n"
      "PSNR             {}\n"
      "CIEDE2000        {:.3f} in the mean, {:.3f} at 95 %, {:.3f} at most\n"
      "error            {:.3f} of 255 in the mean, {:.3f} at most\n",
      is.errors.pixels, is.ssim ? fmt::format("{:.5f}", *is.ssim) : "none: no window of 11 x 11 pixels counts",
      is.hsv.combined(), is.hsv.hue, is.hsv.saturation, is.hsv.value,
      is.errors.psnr_db ? fmt::format("{:.2f} dB", *is.errors.psnr_db) : "without end: the pictures are equal",
      difference.mean, difference.at_95_percent, difference.largest, is.errors.mean_absolute, is.errors.largest);
}

std::string json_of(const ComparedPictures& is, const ComparisonRequest& arguments) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  const auto& difference = is.errors.ciede2000;
  const nlohmann::ordered_json json = {
      {"a", arguments.one},
      {"b", arguments.other},
      {"mask", arguments.mask.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(arguments.mask)},
      {"pixels", is.errors.pixels},
      {"equal", !is.errors.psnr_db},
      {"ssim", or_null(is.ssim)},
      {"hsv_correlation",
       {{"hue", is.hsv.hue},
        {"saturation", is.hsv.saturation},
        {"value", is.hsv.value},
        {"combined", is.hsv.combined()}}},
      {"psnr_db", or_null(is.errors.psnr_db)},
      {"ciede2000",
       {{"mean", difference.mean}, {"at_95_percent", difference.at_95_percent}, {"largest", difference.largest}}},
      {"mean_error", is.errors.mean_absolute},
      {"largest_error", is.errors.largest}};
  return text_of_json(json) + "\n";
}

Result<int> compare(const ComparisonRequest& arguments) {
  const auto one = read_whole_numbers(arguments.one), other = read_whole_numbers(arguments.other);
  if (!one) return fail(one.error());
  if (!other) return fail(other.error());
  if (auto same = same_size(arguments.other, *other, arguments.one, *one); !same) return fail(same.error());
  CountedPixels counted;
  if (!arguments.mask.empty()) {
    const auto mask = read_photograph(arguments.mask);
    if (!mask) return fail(mask.error());
    if (auto same = same_size(arguments.mask, *mask, arguments.one, *one); !same) return fail(same.error());
    counted = counted_in(*mask);
    if (std::ranges::none_of(counted.elements(), [](auto value) { return value != 0; }))
      return fail(FaultKind::bad_input,
                  "{}: all black, so that nothing counts: expected white where the pictures are "
                  "to be compared",
                  arguments.mask);
  }
  const ComparedPictures compared{ssim(one->encoded, other->encoded, counted),
                                  hsv_correlation(one->encoded, other->encoded, counted),
                                  pixel_errors(one->encoded, other->encoded, counted)};
  fmt::print("{}", arguments.json ? json_of(compared, arguments) : text_of(compared));
  return 0;
}

}  // namespace

void add_compare_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("compare", "How alike two pictures of one size are");
  auto arguments = std::make_shared<ComparisonRequest>();
  command->add_option("a", arguments->one, "A picture of 8 or 16 bits")->required();
  command->add_option("b", arguments->other, "Another, of the same size")->required();
  command->add_option("--mask", arguments->mask, "Picture of the same size: white counts, black does not");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, &action] { action = [arguments] { return compare(*arguments); }; });
}

}  // namespace kasumi
