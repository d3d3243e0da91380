// KTX 2.0 specification, "File Structure", and Khronos Data Format Specification 1.3 for its data format descriptor.
#include "gles/packed/ktx2.hpp"

#include <algorithm>

#include <zstd.h>

#include "gles/packed/module.hpp"

namespace kasumi {

namespace {

// As the specifications number them.
enum Ktx2Kind : std::uint32_t { ktx2_etc1s = 163, ktx2_uastc = 166 };
enum Ktx2Packing : std::uint32_t { ktx2_plain = 0, ktx2_basis_lz = 1, ktx2_zstandard = 2 };
constexpr std::size_t kKtx2Header = 80, kKtx2Level = 24;

struct Ktx2Format {
  std::uint32_t kind = 0;
  bool red_green = false;  // the second of two channels stands where transparency does
  bool premultiplied = false;
};

Result<Ktx2Format> format_of(Ktx2Bytes file) {
  constexpr std::size_t kBlock = 28, kSample = 16;
  constexpr std::uint8_t kEtc1sGreen = 4, kUastcRedGreen = 5, kUastcRg = 6;
  const auto text = ktx2_part(file, ktx2_number(file, 48, 4), ktx2_number(file, 52, 4));
  if (!text || text->size() < kBlock) return fail(FaultKind::bad_input, "damaged KTX2: its data format is not there");
  Ktx2Format format{(*text)[12]};
  format.premultiplied = ((*text)[15] & 1u) != 0;
  if (ktx2_number(file, 12, 4) != 0 || (format.kind != ktx2_etc1s && format.kind != ktx2_uastc))
    return fail(
        FaultKind::bad_input,
        "a KTX2 of Vulkan's format {} and colour model {}: expected Basis Universal's ETC1S or UASTC (0 and 163 "
        "or 166); npx @gltf-transform/cli ktxdecompress IN.glb OUT.glb makes PNG of others",
        ktx2_number(file, 12, 4), format.kind);
  for (std::size_t at = kBlock; at + kSample <= text->size(); at += kSample) {
    const auto channel = static_cast<std::uint8_t>((*text)[at + 3] & 15u);
    format.red_green |= format.kind == ktx2_etc1s ? channel == kEtc1sGreen && at > kBlock
                                                  : channel == kUastcRedGreen || channel == kUastcRg;
  }
  return format;
}

// glTF's textures are one flat picture, and so is what this reads.
Result<> expect_one_picture(Ktx2Bytes file) {
  const auto depth = ktx2_number(file, 28, 4), layers = ktx2_number(file, 32, 4), faces = ktx2_number(file, 36, 4);
  if (depth == 0 && layers <= 1 && faces == 1) return {};
  return fail(FaultKind::bad_input, "a KTX2 of depth {}, {} layers and {} faces: expected one flat picture (0, 0, 1)",
              depth, layers, faces);
}

// Not more than the picture needs, whatever the stream claims.
Result<std::vector<std::uint8_t>> unpacked_zstandard(Ktx2Bytes level, std::size_t needed) {
  std::vector<std::uint8_t> bytes(needed);
  const std::size_t got = ZSTD_decompress(bytes.data(), needed, level.data(), level.size());
  if (ZSTD_isError(got) != 0)
    return fail(FaultKind::bad_input, "damaged KTX2: Zstandard says \"{}\"", ZSTD_getErrorName(got));
  bytes.resize(got);
  return bytes;
}

Result<Image<glm::u8vec4>> picture_of(Ktx2Bytes file, const Ktx2Format& format, int width, int height) {
  const auto packing = static_cast<std::uint32_t>(ktx2_number(file, 44, 4));
  const std::uint64_t levels = std::max<std::uint64_t>(1, ktx2_number(file, 40, 4));
  // The first is the largest.
  const auto level = ktx2_part(file, ktx2_number(file, kKtx2Header, 8), ktx2_number(file, kKtx2Header + 8, 8));
  if (!level) return fail(FaultKind::bad_input, "damaged KTX2: its largest picture is not whole");
  if (format.kind == ktx2_etc1s && packing == ktx2_basis_lz) {
    const auto global = ktx2_part(file, ktx2_number(file, 64, 8), ktx2_number(file, 72, 8));
    if (!global) return fail(FaultKind::bad_input, "damaged KTX2: its global data are not whole");
    return read_etc1s(*global, levels, *level, width, height);
  }
  if (format.kind == ktx2_uastc && packing == ktx2_plain) return read_uastc(*level, width, height);
  if (format.kind == ktx2_uastc && packing == ktx2_zstandard) {
    const std::size_t blocks = static_cast<std::size_t>((width + 3) / 4) * static_cast<std::size_t>((height + 3) / 4);
    const auto plain = unpacked_zstandard(*level, 16 * blocks);
    if (!plain) return fail(plain.error());
    return read_uastc(*plain, width, height);
  }
  return fail(FaultKind::bad_input,
              "a KTX2 of {} in packing {}: expected ETC1S in BasisLZ (1), or UASTC in none (0) or Zstandard (2)",
              format.kind == ktx2_etc1s ? "ETC1S" : "UASTC", packing);
}

}  // namespace

Result<Image<glm::u8vec4>> read_ktx2(std::span<const std::uint8_t> file, int width, int height) {
  if (file.size() < kKtx2Header + kKtx2Level || width < 1 || height < 1 ||
      ktx2_number(file, 20, 4) != static_cast<std::uint32_t>(width) ||
      ktx2_number(file, 24, 4) != static_cast<std::uint32_t>(height))
    return fail(FaultKind::bad_input, "damaged KTX2");
  const auto format = format_of(file);
  if (!format) return fail(format.error());
  if (auto one = expect_one_picture(file); !one) return fail(one.error());
  auto image = picture_of(file, *format, width, height);
  if (image && format->red_green)
    for (glm::u8vec4& texel : image->elements()) texel = {texel.r, texel.a, 0, 255};
  else if (image && format->premultiplied)  // glTF's are not
    for (glm::u8vec4& texel : image->elements())
      for (int c = 0; c < 3 && texel.a > 0; ++c)
        texel[c] = static_cast<std::uint8_t>(std::min(255, (255 * texel[c] + texel.a / 2) / texel.a));
  return image;
}

}  // namespace kasumi
