#include "pipeline/lab/prove/proof_sheet.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "pipeline/site/files/contact_sheet.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostPictures = 24;
constexpr int kTripletsAcross = 2, kTileWidth_px = 300, kAmplified = 4;

Image<Rgb8> enlarged(const Image<Rgb8>& picture) {
  const int factor = std::max(1, kTileWidth_px / std::max(1, picture.width()));
  Image<Rgb8> large(picture.width() * factor, picture.height() * factor);
  for (int y = 0; y < large.height(); ++y)
    for (int x = 0; x < large.width(); ++x) large.at(x, y) = picture.at(x / factor, y / factor);
  return large;
}

// From the least extinction to the most.
std::vector<const ProofEntry*> chosen(const Proof& proof) {
  std::vector<const ProofEntry*> judged;
  for (const auto& picture : proof.pictures)
    if (picture.judged()) judged.push_back(&picture);
  std::ranges::stable_sort(judged, {}, [](const auto* picture) { return picture->air.per_m.g; });
  if (judged.size() <= kMostPictures) return judged;
  std::vector<const ProofEntry*> some;
  for (std::size_t k = 0; k < kMostPictures; ++k) some.push_back(judged[k * (judged.size() - 1) / (kMostPictures - 1)]);
  return some;
}

}  // namespace

Image<Rgb8> proof_sheet(const Proof& proof) {
  const auto pictures = chosen(proof);
  if (pictures.empty()) return {};
  const auto &box = proof.scene.part.surface, &patch = proof.scene.patch;
  ContactSheet sheet;
  for (const auto* picture : pictures) {
    const auto& view = proof.scene.views[picture->view];
    auto drawn = view.patch;
    Image<Rgb8> off(patch.width, patch.height, Rgb8{128, 128, 128});
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x) {
        const int px = x + box.x - patch.x, py = y + box.y - patch.y;
        const auto &is = picture->part.at(x, y), seen = view.patch.at(px, py);
        drawn.at(px, py) = is;
        for (int c = 0; c < 3; ++c)
          off.at(px, py)[c] =
              static_cast<std::uint8_t>(std::clamp(128 + kAmplified * (int{is[c]} - int{seen[c]}), 0, 255));
      }
    sheet.add(enlarged(view.patch), view.file.stem().string());
    sheet.add(enlarged(drawn), fmt::format("drawn: {:.1f} off", picture->error_255(ProofWay::told)));
    sheet.add(enlarged(off), picture->air_class);
  }
  return sheet.drawn(3 * kTripletsAcross);
}

}  // namespace kasumi
