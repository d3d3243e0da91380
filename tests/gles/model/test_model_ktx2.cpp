// Pictures of Basis Universal: the pixels are those of its own transcoder, bit by bit, and what is damaged or lies is
// refused. Files and sums of pixels were made outside: by ktx2-encoder 0.6.0 of npm (Basis Universal's encoder) and the
// transcoder that three.js 0.187 brings, into RGBA32.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/model/model.hpp"
#include "gles/model/model_picture.hpp"
#include "tests/gles/model/gltf_writer.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

// A disc on checks, half transparent in places, 22 x 13 pixels: ETC1S in BasisLZ.
constexpr std::string_view kEtc1s =
    "q0tUWCAyMLsNChoKAAAAAAEAAAAWAAAADQAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAADwAAACkAAAAJAAAAMgAAAAAAAAABAEAAAAAAADMAQAA"
    "AAAAACYAAAAAAAAAAAAAAAAAAAA8AAAAAAAAAAIAOACjAQIAAwMAAAgIAAAAAAAAAAA/AAAAAAAAAAAA/////0AAPw8AAAAAAAAAAP////8fAAAA"
    "S1RYd3JpdGVyAEJhc2lzIFVuaXZlcnNhbCAyLjUwAAAZABIAYQAAADsAAABAAAAAAAAAAAAAAAAAAAAAEwAAABMAAAATAAAAIEAcAAEAAEFYePp1"
    "xSAUBHgDIACAIGyzpCcQr0LEeQBvAAQAAIJxaoVS2rEhABEABAAABEF+lIgIAby7m5kF4vtrQJEsQJLVeVB1l+ee7bZyf6XP0OmxC+UIO18EJlVS"
    "NKAH5gQUgCAQANBvAhYtQQmuBIsRSHFRfG6Qgk6oqqICyJ/8lojozx1cfWPUWmVmYiMoOGu8s7ViAwUHAEFkAAAAgEEgRI/JzCWIAIIM6DKAuQED"
    "AACCACzoCTAUB3hsKwCEIJRpfqCniovaSVdwggoAJgAAAAAAABBAAEgcvL9OA9zgA7jmBdkKqj4zYjI7hyhZsap2cjFdUvzjg6zeFJEw";

// 75 x 14 pixels: four blocks of random bits for each of UASTC's 19 modes, with no packing.
constexpr std::string_view kUastc =
    "q0tUWCAyMLsNChoKAAAAAAEAAABLAAAADgAAAAAAAAAAAAAAAQAAAAEAAAAAAAAAaAAAACwAAACUAAAALAAAAAAAAAAAAAAAAAAAAAAAAADAAAAA"
    "AAAAAMAEAAAAAAAAwAQAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AwAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMg"
    "VW5pdmVyc2FsIDIuNTAAAAQAAAB/fwAAUYKU91A57PZiXYZxZ4J6n/WYTzkOb1voJ9Xu/ItQ94VdvKM+XtFTRXA3ItuZrhgv42qpHuKEVsUstaeZ"
    "Enr34rOiJZmeSWR1lnZNrnQhLx2rIliL4JiPfYOEphhaxW5gmyEyQ5tGyiT8NSrsLAE8tsfqpcR8ACDNrrQCGNePQiX3TbMAyiTatXpYlpKNKMOu"
    "75r6Jd50T70f6x+EuzMbbjp1Wo8Ebs6wyOnzTFJOlnI476TOjSQlHsRi5HmjiAVJLhioccilJZZlZ8Ca/fI3hH8ANQgGAZ2p+gdZQbCc/LEttxwk"
    "l0lf6NJTfv0MlSVihU0sVMuLOeA/Wv9dYe6BJtXSNinx2f0kjyys8wC34Y4lVQozWkF5QhTaVU44/xMpeeh3AVbVfsscc8r+Wdfph7FQeCzzFssU"
    "AhmCC5tquuk1kd1H9ozNmx5iM+v4u1swnSmRWAmH3E2K/wZxWxTEGwMEKPkszuZqn8Sm+JO6T/vTpXOqvCk/GC1QiYIu+KXV66Kk68AwfArVcWOG"
    "yfTRVZs5snEy2+MLpf/ZQ2UQfHEH7JsifpwIqyFFL71TaMAv13G6X0W+2ZE5Gimxr2Eqlg8xVOaGFgk2nMajgf63zr7CyLzjV3HHhtBGvnbSlbkL"
    "UEjD5Qfh4xIlq0oifQy+DQa/OX3odSxq6wQXFE4sqlI/Pu06Rz5zHnJh9dyVBE9sDdWwrXdKiL0K07QKo6V86gWUUWbGqzvZA2kkLcYfAlxVi6Hz"
    "hW9c/6w0FtdQga9TZcpw5wSou8JXQliXkNxWXolgjdCSZSexU6a7/dc/xA3RPDawowjDHhX7DN81geDRtbVQBSaUlkq+xEplT+29mt0PrsB2Pjui"
    "xYs+IssZyCgjeKDid/TTVm73xL+9loG+sxthCcX8TuN6P7l3tJl2vysBfPhSij1XLm6ARLTKFxRbfgjt9UlOAs3KbX7dnfdYh+r1WtOGptrLlKeF"
    "DfZf/Ncb6guhHejfJXpollqJPi/PW+FUSlMRMH3uF5RNwkbiwvybgz8mjS+04PxKIzz72/gN6SnSpixqGV/nRiwHLqm+oJrVUeO+cft7qBq5Na3c"
    "X8N/GA3tE9asRRBUGdRKBS2IZ4FV1foneszthpz01bIF/SOgeqpE9rcgED6Spx11lTODB8x7wdCxUkoOS/ry3uU6VkSaWkFIuXFphBgAJHuJIm3n"
    "NlaU7SCOPzJIx4Tekdcc9oUEo/0wpyl8unKvT/UZqAiWQXpCsqRsn2jUVaJdBa0xcXQp9d+GO8kW8M4bIyhmfNN/e7ihHq7ehY+vM7Mvkf4i1mm2"
    "LMveebmWltVLZLDZ3XJkP4g1CBlDRkULO5i4AP8dkkmAUSMEEu0nvaeXzX49rwdl+96ZyhdVmId3/TCVoFd1pnM9+fGxbGKTb05BIr8FyxkMLVUU"
    "IWNb2PLJS0coKXh60YK8vxGUpsNkfh6UK9NNWBFP/oHRERPkFn2JmBcUGkQboevssuhzzF/VXOQ9+q/OQIpUjwIqlQptmGgH7ZfbhtEaB/oT5kou"
    "hdV9knb6cPwcYNW8NC1gyFWbahQpMzy/cmyPZ7YPqmkl+wAeVlIQYCROA4rnm/WguQUOP0xnvG+AFwO1GeIT/Q==";

// The disc again: UASTC in Zstandard.
constexpr std::string_view kUastcZ =
    "q0tUWCAyMLsNChoKAAAAAAEAAAAWAAAADQAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAAAAAAAAAAAAC4AAAA"
    "AAAAADoBAAAAAAAAgAEAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AwAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMg"
    "VW5pdmVyc2FsIDIuNTAAACi1L/1ggACFCQDED18B3SEKilYXYyIgIAWlrw/fE9AhCopXGP/BAZmv+ZjvogzAPwAAwA//sQaJrzma8ABfAVobEOhw"
    "BoJT/ONcVVVVmZnd3R+B32Ihf1JvFor5l++hB+A/AAwMDNfcV+Z/1pUA/xsFibmvb5oM4j8ADAAAAFobEOiQMBQREREU6OhZZKq+AwgABAAEABUR"
    "f8EOma/5l6+gDMA//1JgljmK75hH4D8gADDwD//abaY5ii+ahwz/DzK/EOiIVmSyvwOIiISIhIiVOXSo4gAcERUc6Ig2dCjjAJzdlRToaBiCM+Pg"
    "VJlRFOjoHBRRETDjEOjgOXRQ4ABcVVVVVVVVVRcosIIKah4QUIt2A8KBQmvMCf31hRvVqjacawIzOJeaRxEMG/CCO9SObOM2m1xqDDpj";

constexpr std::size_t kFormatAt = 12, kWidthAt = 20, kFacesAt = 36, kPackingAt = 44, kLevelAt = 80, kColoursAt = 116;

Bytes bytes_of(std::string_view base64) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  Bytes bytes;
  std::uint32_t kept = 0;
  int bits = 0;
  for (const char digit : base64.substr(0, base64.find('='))) {
    kept = kept << 6 | static_cast<std::uint32_t>(kDigits.find(digit));
    if ((bits += 6) < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<std::uint8_t>(kept >> bits));
  }
  return bytes;
}

// FNV-1a of 64 bits.
std::uint64_t sum_of(const Image<glm::u8vec4>& image) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const glm::u8vec4& texel : image.elements())
    for (int c = 0; c < 4; ++c) sum = (sum ^ texel[c]) * 0x100000001b3u;
  return sum;
}

std::string refusal_of(const Bytes& file) {
  const auto picture = decode_picture(file, 4096);
  return picture ? "it is read" : picture.error().message;
}

TEST(Ktx2, HasThePixelsOfBasisUniversalsTranscoder) {
  struct Truth {
    std::string_view file;
    int width, height;
    std::uint64_t sum;
  };
  for (const Truth& truth : {Truth{kEtc1s, 22, 13, 0x6ab69d466cf4521bu}, Truth{kUastc, 75, 14, 0xb393fb1c956b67eau},
                             Truth{kUastcZ, 22, 13, 0x3b21fafc14fa7c32u}}) {
    const auto picture = must(decode_picture(bytes_of(truth.file), 4096));
    EXPECT_EQ(picture->width(), truth.width);
    EXPECT_EQ(picture->height(), truth.height);
    EXPECT_EQ(sum_of(*picture), truth.sum) << truth.file.substr(0, 100);
  }
}

TEST(Ktx2, IsTheTextureOfAModelThatRequiresIt) {
  GltfFile file = square_file();
  file.json["extensionsRequired"] = {"KHR_texture_basisu"};
  file.json["images"] = {{{"uri", "data:image/ktx2;base64," + std::string(kEtc1s)}}};
  file.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({0, 1, 1, 1, 1, 0, 0, 0}, 2);
  file.primitive()["material"] = 0;
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  const Model model = loaded(file.read("ktx2"));
  ASSERT_EQ(model.textures.size(), 1u);
  EXPECT_EQ(sum_of(model.textures[0].pixels), 0x6ab69d466cf4521bu);
  EXPECT_THAT(model.notes, testing::IsEmpty());
}

TEST(Ktx2, ASecondChannelCalledGreenIsGreen) {
  Bytes file = bytes_of(kEtc1s);
  const auto before = must(decode_picture(file, 4096));
  file[151] = 0x44;  // the second sample's channel: 15 is transparency, 4 green
  const auto after = must(decode_picture(file, 4096));
  for (std::size_t i = 0; i < before->elements().size(); ++i) {
    const glm::u8vec4 from = before->elements()[i];
    ASSERT_EQ(after->elements()[i], glm::u8vec4(from.r, from.a, 0, 255)) << i;
  }
}

TEST(Ktx2, ColoursThatAreMultipliedByAlphaAreDividedByIt) {
  Bytes file = bytes_of(kEtc1s);
  const auto before = must(decode_picture(file, 4096));
  file[119] |= 1u;  // flags: alpha is premultiplied
  const auto after = must(decode_picture(file, 4096));
  int soft = 0;
  for (std::size_t i = 0; i < before->elements().size(); ++i) {
    const glm::u8vec4 from = before->elements()[i], to = after->elements()[i];
    ASSERT_EQ(to.a, from.a);
    if (from.a == 0) continue;
    soft += from.a < 255 ? 1 : 0;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(to[c], std::min(255.0, 255.0 * from[c] / from.a), 0.51) << i;
  }
  EXPECT_GT(soft, 20);
}

TEST(Ktx2, EachFalseClaimIsRefusedByName) {
  struct Claim {
    std::string what;
    std::string_view file;
    std::size_t at;
    Bytes bytes;
    std::string answer;
  };
  const Bytes kMost(8, 0xff);
  const std::vector<Claim> claims{
      {"16 million pixels a side", kEtc1s, kWidthAt, {0, 0, 0, 1}, "expected 1 .. 4096"},
      {"no pixels", kUastc, kWidthAt, {0, 0, 0, 0}, "expected 1 .. 4096"},
      {"more rows than blocks", kUastc, kWidthAt + 4, {0, 1, 0, 0}, "damaged UASTC: 1216 bytes for 75 x 256"},
      {"another file's kind of pixels", kUastc, kFormatAt, {37, 0, 0, 0}, "Vulkan's format 37"},
      {"six faces", kUastc, kFacesAt, {6}, "6 faces"},
      {"four thousand million layers", kEtc1s, kFacesAt - 4, {0xff, 0xff, 0xff, 0xff}, "4294967295 layers"},
      {"ETC1S without packing", kEtc1s, kPackingAt, {0}, "ETC1S in packing 0"},
      {"UASTC in BasisLZ", kUastc, kPackingAt, {1}, "UASTC in packing 1"},
      {"UASTC called Zstandard", kUastc, kPackingAt, {2}, "Zstandard says"},
      {"a data format beyond the file", kEtc1s, 48, {0xff, 0xff, 0xff, 0xff}, "data format is not there"},
      {"the colour model of another", kEtc1s, kColoursAt, {167}, "colour model 167"},
      {"a level beyond the file", kEtc1s, kLevelAt, kMost, "largest picture is not whole"},
      {"a level as long as there are numbers", kUastcZ, kLevelAt + 8, kMost, "largest picture is not whole"},
      {"global data beyond the file", kEtc1s, 64, kMost, "global data are not whole"},
      {"four thousand million levels", kEtc1s, 40, {0xff, 0xff, 0xff, 0xff}, "global data are not whole"},
  };
  for (const Claim& claim : claims) {
    Bytes file = bytes_of(claim.file);
    std::ranges::copy(claim.bytes, file.begin() + static_cast<std::ptrdiff_t>(claim.at));
    EXPECT_THAT(refusal_of(file), HasSubstr(claim.answer)) << claim.what;
  }
}

TEST(Ktx2, CountsOfBasisLzThatAreFalseAreRefused) {
  const Bytes whole = bytes_of(kEtc1s);
  std::size_t global = 0;
  for (std::size_t i = 4; i-- > 0;) global = global << 8 | whole[64 + i];
  // Counts of colours and selectors, lengths of their books and of the codes, the slices' places and lengths.
  for (const std::size_t at : {0u, 2u, 4u, 8u, 12u, 24u, 28u, 32u, 36u})
    for (const std::uint8_t byte : Bytes{0xff, 0x00}) {
      Bytes file = whole;
      const std::size_t count = at < 4 ? 2 : 4;
      std::fill_n(file.begin() + static_cast<std::ptrdiff_t>(global + at), count, byte);
      if (file == whole || (byte == 0 && at >= 24)) continue;  // slices at 0 are there, no transparency is allowed
      EXPECT_THAT(refusal_of(file), HasSubstr("damaged")) << at << " " << int{byte};
    }
}

TEST(Ktx2, CutOrChangedAnywhereItIsReadOrRefused) {
  for (const std::string_view text : {kEtc1s, kUastc, kUastcZ}) {
    const Bytes whole = bytes_of(text);
    for (std::size_t length = 0; length < whole.size(); ++length)
      EXPECT_NE(refusal_of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)}), "it is read")
          << length;
    for (std::size_t at = 28; at < whole.size(); ++at)
      for (const std::uint8_t change : Bytes{0x01, 0x80, 0xff}) {
        Bytes file = whole;
        file[at] = static_cast<std::uint8_t>(file[at] ^ change);
        EXPECT_THAT(refusal_of(file), testing::Not(testing::IsEmpty())) << at;
      }
  }
}

}  // namespace
}  // namespace kasumi
