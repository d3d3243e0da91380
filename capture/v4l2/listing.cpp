#include <algorithm>

#include "capture/v4l2/offer.hpp"
#include "capture/v4l2/v4l2_source.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

// The names in a folder, sorted; none when it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    entries.push_back(it->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

std::vector<fs::path> stable_paths_of(const fs::path& node, const fs::path& devices) {
  std::vector<fs::path> paths;
  std::error_code error;
  const auto real = fs::canonical(node, error);
  if (error) return paths;
  for (const auto* folder : {"by-id", "by-path"})
    for (const auto& link : entries_of(devices / "v4l" / folder))
      if (fs::canonical(link, error) == real && !error) paths.push_back(link);
  return paths;
}

// Empty: not a capture device.
std::optional<V4l2Listing> listing_of(const fs::path& node, const fs::path& devices) {
  V4l2Listing listing;
  listing.node = node;
  listing.stable_paths = stable_paths_of(node, devices);
  auto device = open_video_device(node);
  if (!device) {
    if (device.error().kind != FaultKind::device) return std::nullopt;
    listing.problem = device.error().message;
    return listing;
  }
  const auto identity = identify_v4l2(**device);
  if (!identity) {
    if (identity.error().kind != FaultKind::device) return std::nullopt;
    listing.problem = identity.error().message;
    return listing;
  }
  listing.driver = identity->driver;
  listing.card = identity->card;
  listing.place = identity->place;
  for (const auto& offer : v4l2_offers(**device, identity->buffer_type))
    if (offer.format) listing.formats.push_back(describe_v4l2_offer(**device, offer));
  return listing;
}

}  // namespace

std::vector<V4l2Listing> list_v4l2_cameras(const fs::path& devices) {
  std::vector<V4l2Listing> listings;
  for (const auto& node : video_nodes(devices))
    if (auto listing = listing_of(node, devices)) listings.push_back(std::move(*listing));
  return listings;
}

}  // namespace kasumi
