#include "calib/distances/distance_numbers.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>

#include <fmt/ranges.h>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/picture_files/decode_picture.hpp"
#include "base/picture_files/rare_files.hpp"
#include "base/picture_header.hpp"

namespace kasumi {
namespace {

constexpr double kLargestHalf = 65504.0;
constexpr const char* kExpected = "expected a depth map: a grey PNG of 16 bits, a PFM, or an EXR or TIFF of floats";

// Three lines, then rows from the bottom. The third line's sign is the order of bytes; its size is no unit.
Result<cv::Mat> decode_pfm(const PictureHeader& header, const std::vector<std::uint8_t>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 1024));
  if (text.starts_with("PF")) return fail(FaultKind::bad_input, "a PFM of three colours: {}", kExpected);
  std::size_t at = 2;
  std::string last;
  for (int word = 0; word < 3; ++word) {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    const auto from = at;
    while (at < text.size() && !std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    last = text.substr(from, at - from);
  }
  ++at;  // one space ends the header
  const auto width = static_cast<std::size_t>(header.width), height = static_cast<std::size_t>(header.height);
  if (last.empty() || bytes.size() < at + 4 * width * height)
    return fail(FaultKind::bad_input, "the PFM ends too early");
  const bool swapped = (last[0] == '-') != (std::endian::native == std::endian::little);
  cv::Mat values(static_cast<int>(height), static_cast<int>(width), CV_32F);
  for (std::size_t y = 0; y < height; ++y) {
    auto* row = values.ptr<std::uint8_t>(static_cast<int>(height - 1 - y));
    std::memcpy(row, bytes.data() + at + 4 * width * y, 4 * width);
    for (std::size_t x = 0; swapped && x < 4 * width; x += 4) std::reverse(row + x, row + x + 4);
  }
  return values;
}

std::string in_small_letters(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// How likely a channel holds distances; 0: not by its name.
int rank_of(const std::string& channel) {
  const auto name = in_small_letters(channel);
  const auto last = name.substr(name.rfind('.') + 1);
  if (name == "z") return 7;
  if (last == "z") return name.find("depth") != std::string::npos ? 6 : 4;
  if (last == "v" || last == "depth" || name.find("depth.") != std::string::npos) return 5;
  if (last == "distance") return 5;
  return last == "y" ? 3 : 0;
}

bool all_equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.total() > 0 && std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

Result<std::string> chosen_channel(const RareFiles& files, std::span<const std::uint8_t> bytes,
                                   const std::vector<std::string>& names, const std::string& wanted) {
  const auto has = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
  if (!wanted.empty()) {
    if (has(wanted)) return wanted;
    return fail(FaultKind::bad_input, "no channel {}: expected one of {}", wanted, fmt::join(names, ", "));
  }
  const auto best = std::ranges::max_element(names, {}, rank_of);
  if (rank_of(*best) > 0) return *best;
  if (names.size() == 1) return names.front();
  if (has("R") && (!has("G") || all_equal(files.exr_channel(bytes, "R"), files.exr_channel(bytes, "G"))))
    return std::string("R");
  return fail(FaultKind::bad_input,
              "its channels are {}, none of them distances by its name: expected Z or --depth-channel "
              "(depth_channel)",
              fmt::join(names, ", "));
}

Result<DistanceNumbers> decode_exr(const std::vector<std::uint8_t>& bytes, const std::string& wanted) {
  const auto files = rare_files();
  if (!files) return fail(files.error());
  auto names = (*files)->exr_channels(bytes);
  if (names.empty()) return fail(FaultKind::bad_input, "not an EXR that can be read (deep pictures are not)");
  const auto name = chosen_channel(**files, bytes, names, wanted);
  if (!name) return fail(name.error());
  DistanceNumbers numbers;
  numbers.values = (*files)->exr_channel(bytes, *name);
  if (numbers.values.empty()) return fail(FaultKind::bad_input, "channel {} cannot be read", *name);
  std::erase(names, *name);
  numbers.other_channels = fmt::format("{}", fmt::join(names, ", "));
  if (!names.empty()) numbers.remarks.push_back(fmt::format("channel {} of it", *name));
  return numbers;
}

// Grey that is written as three or four equal colours.
cv::Mat one_channel(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  std::vector<cv::Mat> parts;
  cv::split(picture, parts);
  if (parts.size() < 3 || !all_equal(parts[0], parts[1]) || !all_equal(parts[0], parts[2])) return {};
  return parts[0];
}

// .npy, as the networks that see distances write them, or several in a .npz, which is a ZIP.
bool is_numpy(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 200));
  return text.starts_with("\x93NUMPY") || (text.starts_with("PK\3\4") && text.find(".npy") != std::string_view::npos);
}

Result<DistanceNumbers> decode(const std::vector<std::uint8_t>& bytes, const std::string& channel) {
  const auto header = picture_header(bytes);
  if (!header && is_numpy(bytes))
    return fail(
        FaultKind::bad_input,
        "an array of NumPy: {}; cv2.imwrite('OUT.tiff', numpy.load('IN.npy').astype('float32').squeeze()) makes one",
        kExpected);
  if (!header) return fail(FaultKind::bad_input, "{}", kExpected);
  if (auto bounded = check_size(*header, kPhotographLimits); !bounded) return fail(bounded.error());
  if (header->format == "EXR") return decode_exr(bytes, channel);
  if (!channel.empty())
    return fail(FaultKind::bad_input, "a {} has no channels by name: expected no --depth-channel (depth_channel)",
                header->format);
  auto read = header->format == "PFM" ? decode_pfm(*header, bytes) : decode_picture_file(*header, bytes);
  if (!read && read.error().kind == FaultKind::bad_input && header->format != "PFM")
    return fail(FaultKind::bad_input, "{} ({})", kExpected, read.error().message);
  if (!read) return fail(read.error());
  const cv::Mat grey = one_channel(*read);
  if (grey.empty()) return fail(FaultKind::bad_input, "a picture of colours: {}", kExpected);
  DistanceNumbers numbers;
  if (grey.depth() == CV_8U) return fail(FaultKind::bad_input, "8 bits, 256 distances at most: {}", kExpected);
  if (grey.depth() == CV_16U || grey.depth() == CV_32F)
    numbers.values = grey;
  else if (grey.depth() == CV_64F)
    grey.convertTo(numbers.values, CV_32F);
  else
    return fail(FaultKind::bad_input, "{}", kExpected);
  return numbers;
}

}  // namespace

Result<DistanceNumbers> read_distance_numbers(const std::filesystem::path& path, const std::string& channel) {
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  auto numbers = decode(*bytes, channel);
  if (!numbers) return fail(numbers.error().kind, "{}: {}", path.string(), numbers.error().message);
  numbers->are_whole = numbers->values.depth() == CV_16U;
  if (numbers->are_whole)
    numbers->saturated = 65535.0;
  else
    numbers->background = kLargestHalf;
  return numbers;
}

}  // namespace kasumi
