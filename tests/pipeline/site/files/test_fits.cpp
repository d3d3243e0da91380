// FITS pictures of all-sky cameras, written here by hand as the standard has it.
#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <functional>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_source.hpp"
#include "pipeline/site/files/picture_times.hpp"
#include "pipeline/site/files/taken_at.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kWide = 24, kHigh = 18;
using Light = std::function<double(int x, int y, int colour)>;  // 0..1, y from above

std::string card(const std::string& text) {
  return text + std::string(80 - text.size(), ' ');
}
std::string key(const std::string& name, const std::string& value) {
  return card(fmt::format("{:<8}= {:>20}", name, value));
}
std::string in_blocks(std::string text, char with) {
  text.resize((text.size() + 2879) / 2880 * 2880, with);
  return text;
}
std::string header(int bits, int planes, const std::string& more, int width = kWide, int height = kHigh) {
  std::string text = key("SIMPLE", "T") + key("BITPIX", std::to_string(bits)) + key("NAXIS", planes == 1 ? "2" : "3") +
                     key("NAXIS1", std::to_string(width)) + key("NAXIS2", std::to_string(height));
  if (planes > 1) text += key("NAXIS3", std::to_string(planes));
  return in_blocks(text + more + card("END"), ' ');
}
std::string big_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> 8 * i);
  return text;
}
std::string as_word(double light) {  // by BZERO = 32768
  return big_endian(static_cast<std::uint32_t>(std::lround(65535.0 * light)) ^ 0x8000u, 2);
}
const std::string kUnsigned = key("BSCALE", "1") + key("BZERO", "32768");

double coded(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}

// Smooth, so that what lies between the samples of a mosaic is known.
double gradient(int x, int y, int colour) {
  return 0.02 + 0.01 * x + 0.005 * y + (colour == 0 ? 0.3 : colour == 1 ? 0.1 : 0.0);
}

class FitsPictures : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder); }
  Result<Photograph> read(const std::string& bytes) const {
    EXPECT_TRUE(write_text_file(file, bytes));
    return read_photograph(file);
  }
  std::string problem_of(const std::string& bytes) const {
    const auto photograph = read(bytes);
    return photograph ? "none" : photograph.error().message;
  }
  // Away from the edges.
  void expect_light(const std::string& bytes, const Light& light, double within) const {
    const auto photograph = read(bytes);
    ASSERT_TRUE(photograph) << photograph.error().message;
    ASSERT_EQ(photograph->encoded.width(), kWide);
    ASSERT_EQ(photograph->encoded.height(), kHigh);
    EXPECT_NEAR(photograph->quantum, 1.0 / 65535.0, 1e-12);
    for (int y = 2; y < kHigh - 2; ++y)
      for (int x = 2; x < kWide - 2; ++x)
        for (int colour = 0; colour < 3; ++colour)
          ASSERT_NEAR(photograph->encoded.at(x, y)[colour], coded(light(x, y, colour)), within)
              << x << " " << y << " " << colour;
  }
  static std::string rows(bool from_below, const std::function<std::string(int x, int y)>& sample) {
    std::string text;
    for (int row = 0; row < kHigh; ++row)
      for (int x = 0; x < kWide; ++x) text += sample(x, from_below ? kHigh - 1 - row : row);
    return text;
  }
  const std::filesystem::path folder = test_folder("fits"), file = folder / "sky.fits";
};

TEST_F(FitsPictures, GreyOfSixteenBitsStandsUprightFromBelow) {
  const auto sample = [](int x, int y) { return as_word(gradient(x, y, 2)); };
  const auto grey = [](int x, int y, int) { return gradient(x, y, 2); };
  expect_light(header(16, 1, kUnsigned) + in_blocks(rows(true, sample), '\0'), grey, 1e-3);
  expect_light(header(16, 1, kUnsigned + key("ROWORDER", "'BOTTOM-UP'")) + in_blocks(rows(true, sample), '\0'), grey,
               1e-3);
  expect_light(header(16, 1, kUnsigned + key("ROWORDER", "'TOP-DOWN'")) + in_blocks(rows(false, sample), '\0'), grey,
               1e-3);
}

// Each order of the colours, and a window on the sensor that begins at an odd pixel.
TEST_F(FitsPictures, BayersPatternBecomesColour) {
  for (const std::string pattern : {"RGGB", "BGGR", "GRBG", "GBRG"})
    for (const int off : {0, 1}) {
      const auto sample = [&](int x, int y) {
        const auto colour =
            std::string("RGB").find(pattern[static_cast<std::size_t>(2 * ((y + off) % 2) + (x + off) % 2)]);
        return as_word(gradient(x, y, static_cast<int>(colour)));
      };
      const auto more = kUnsigned + key("BAYERPAT", "'" + pattern + "    '") + key("XBAYROFF", std::to_string(off)) +
                        key("YBAYROFF", std::to_string(off)) + key("ROWORDER", "'TOP-DOWN'");
      SCOPED_TRACE(pattern);
      expect_light(header(16, 1, more) + in_blocks(rows(false, sample), '\0'), gradient, 2e-3);
    }
}

TEST_F(FitsPictures, PlanesOfFloatsAreColours) {
  std::string planes;
  for (int colour = 0; colour < 3; ++colour)
    planes += rows(true, [&](int x, int y) {
      return big_endian(std::bit_cast<std::uint32_t>(static_cast<float>(gradient(x, y, colour))), 4);
    });
  expect_light(header(-32, 3, key("DATAMAX", "1.0")) + in_blocks(planes, '\0'), gradient, 1e-3);
}

// A sensor of 12 bits says where it is full.
TEST_F(FitsPictures, TheBrightestValueIsAsTheHeaderSays) {
  const auto sample = [](int x, int y) { return as_word(gradient(x, y, 1) / 16.0); };
  expect_light(
      header(16, 1, kUnsigned + key("SATURATE", "4095.9375")) + in_blocks(rows(true, sample), '\0'),
      [](int x, int y, int) { return gradient(x, y, 1); }, 5e-3);
}

TEST_F(FitsPictures, TheirTimeIsInTheHeader) {
  ASSERT_TRUE(write_text_file(file, header(16, 1, kUnsigned + key("DATE-OBS", "'2019-05-01T12:34:56.789' / UTC"))));
  EXPECT_EQ(utc_text(picture_time(file, {"", 9.0}).value()), "2019-05-01T12:34:56.789Z") << "its zone is UTC";
  ASSERT_TRUE(write_text_file(file, header(16, 1, key("DATE-OBS", "'yesterday'"))));
  EXPECT_FALSE(picture_time(file, {}));
  EXPECT_TRUE(is_picture_file("a.FITS") && is_picture_file("a.fit") && is_picture_file("a.fts"));
}

// As INDI, indi-allsky, N.I.N.A., Sequence Generator Pro and observatories write them.
TEST_F(FitsPictures, TimeAndPlaceAreReadAsProgramsWriteThem) {
  const auto taken = [](const std::string& cards) {
    const auto bytes = header(16, 1, cards);
    return taken_at({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  };
  const auto utc = [&](const std::string& cards) {
    const auto at = taken(cards);
    return at.utc ? utc_text(*at.utc) : at.wall ? "wall " + utc_text(*at.wall) : std::string("none");
  };
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01T12:34:56.789' / UTC start date of observation")),
            "2024-05-01T12:34:56.789Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01T14:34:56.123456+02:00'")), "2024-05-01T12:34:56.123456Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2020-05-30T00:22:49.0968820' / UTC observation date")), "2020-05-30T00:22:49.096882Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01'") + card("TIME-OBS= '12:34:56'")), "2024-05-01T12:34:56Z");
  EXPECT_EQ(utc(card("DATE-BEG= '2024-05-01T12:34:56Z'")), "2024-05-01T12:34:56Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01T14:34:56' / local time")), "wall 2024-05-01T14:34:56Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01T14:34:56'") + card("TIMESYS = 'LOCAL'")), "wall 2024-05-01T14:34:56Z");
  EXPECT_EQ(utc(card("DATE-OBS= '2024-05-01T14:34:56 noon'")), "none");
  const auto place = [&](const std::string& cards) {
    const auto at = taken(cards).place;
    return at ? fmt::format("{:.3f} {:.3f} {:.0f}", at->latitude_deg, at->longitude_deg, at->altitude_m.value_or(-1.0))
              : std::string("none");
  };
  EXPECT_EQ(
      place(card("SITELAT =          46.94 / degrees") + card("SITELONG=         351.72") + key("SITEELEV", "460.")),
      "46.940 -8.280 460")
      << "INDI counts to 360";
  EXPECT_EQ(place(card("SITELAT = '51 3 0.000'         / Latitude") + card("SITELONG= '-3 43 30.000'")),
            "51.050 -3.725 -1");
  EXPECT_EQ(place(card("LAT-OBS = '33:51:25 S'") + card("LONG-OBS= '151:12:33 E'") + key("ALT-OBS", "30")),
            "-33.857 151.209 30");
  EXPECT_EQ(place(key("OBSGEO-B", "46.5") + key("OBSGEO-L", "7.25") + key("OBSGEO-H", "900")), "46.500 7.250 900");
  EXPECT_EQ(place(key("OBSGEO-X", "5327448.9957829") + key("OBSGEO-Y", "-1718665.73869569") +
                  key("OBSGEO-Z", "3051566.90295403")),
            "28.758 -17.880 2327")
      << "La Palma, at 28.7583 N";
  EXPECT_EQ(place(key("SITELAT", "0.0") + key("SITELONG", "0.0")), "none") << "as nobody set it";
  EXPECT_EQ(place(key("SITELAT", "95.0") + key("SITELONG", "8.0")), "none");
  EXPECT_EQ(place(card("SITELAT = 'north'") + key("SITELONG", "8.0")), "none");
}

TEST_F(FitsPictures, HostileOnesAreRefusedInWords) {
  const auto data = in_blocks(rows(true, [](int, int) { return as_word(0.5); }), '\0');
  const std::vector<std::pair<std::string, const char*>> files{
      {header(16, 1, kUnsigned), "NAXIS1 = 24, NAXIS2 = 18, BITPIX = 16 that ends after 2880 bytes, expected 3744"},
      {header(16, 1, kUnsigned, 2'000'000, 2'000'000), "a FITS of 2000000 x 2000000 pixels: expected"},
      {header(16, 1, kUnsigned, 1'000'000'000, 18) + data, "a FITS of 1000000000 x 18 pixels: expected"},
      {header(16, 1, kUnsigned, 32'000, 4'000) + data, "that ends after"},
      {header(16, 1, kUnsigned, -5, 4) + data, "a FITS of -5 x 4 pixels: expected"},
      {header(16, 7, kUnsigned) + data, "a FITS of NAXIS = 3, NAXIS3 = 7, expected"},
      {header(17, 1, kUnsigned) + data, "a FITS that cannot be read: "},
      {header(16, 1, kUnsigned + key("BAYERPAT", "'RGBW'")) + data, "a FITS of BAYERPAT 'RGBW', expected RGGB"},
      {header(-32, 1, "") + in_blocks(std::string(kWide * kHigh * 4, '\0'), '\0'), "a FITS without any light"},
      {in_blocks(key("SIMPLE", "T") + key("BITPIX", "8") + key("NAXIS", "0") + card("END"), ' '),
       "a FITS of NAXIS = 0 in its first header: expected a picture there, uncompressed (funpack)"},
      {key("SIMPLE", "T"), "sky.fits: "},
      {in_blocks("SIMPLE  = is what this text begins with, and no more.", ' '), "sky.fits: "},
      {in_blocks(key("SIMPLE", "T") + key("BITPIX", "16") + key("NAXIS", "0") + card("END"), ' ') +
           in_blocks(card("XTENSION= 'BINTABLE'") + key("BITPIX", "8") + key("NAXIS", "2") + key("NAXIS1", "8") +
                         key("NAXIS2", "18") + key("PCOUNT", "0") + key("GCOUNT", "1") + key("TFIELDS", "1") +
                         key("TFORM1", "'1PB(9)'") + key("TTYPE1", "'COMPRESSED_DATA'") + key("ZIMAGE", "T") +
                         key("ZCMPTYPE", "'RICE_1'") + key("ZBITPIX", "16") + key("ZNAXIS", "2") +
                         key("ZNAXIS1", "24") + key("ZNAXIS2", "18") + card("END"),
                     ' ') +
           in_blocks(std::string(144, '\0'), '\0'),
       "a FITS of NAXIS = 0 in its first header: expected a picture there, uncompressed (funpack)"},
  };
  for (const auto& [bytes, words] : files)
    EXPECT_THAT(problem_of(bytes), AllOf(HasSubstr("sky.fits"), HasSubstr(words)));
  // Cut anywhere, and any byte of the header another: a picture or words, never an end of the program.
  const auto whole = header(16, 1, kUnsigned + key("BAYERPAT", "'RGGB'")) + data;
  for (std::size_t cut = 0; cut < 3744; cut += 97)  // behind are the zeros that fill the last block
    EXPECT_NE(problem_of(whole.substr(0, cut)), "none") << cut;
  for (std::size_t at = 0; at < 720; at += 7)
    for (const char other : {'9', '-', '\'', '\0'}) {
      auto changed = whole;
      changed[at] = other;
      problem_of(changed);
    }
}

}  // namespace
}  // namespace kasumi
