// How the repository's code reads what may be damaged.
#include <algorithm>
#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/house/repository.hpp"

namespace kasumi::house {
namespace {

// A stream's raw iterators throw where a disk cannot read a sector, in whatever thread that is; read_file() of
// base/files.hpp says which file and why.
TEST(Reading, NothingReadsThroughIteratorsThatThrow) {
  const std::string forbidden = std::string("istreambuf_") + "iterator";
  std::vector<std::string> found;
  int files = 0;
  for (const auto& [name, text] : texts_ending_in(repository_files(), {".cpp", ".hpp", ".h", ".in"})) {
    ++files;
    if (text.find(forbidden) != std::string::npos) found.push_back(name);
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GT(files, 500);
}

// A decoder takes the memory that a picture's header claims.
TEST(Reading, NoPictureIsDecodedBeforeItsSizeIsKnown) {
  std::vector<std::string> decoders, found;
  for (const auto& [name, text] : texts_ending_in(repository_files(), {".cpp", ".hpp"})) {
    if (name.starts_with("tests/") || name.starts_with("fixtures/")) continue;
    // What decodes without knowing whose file it is: whoever calls it has bounded the file's size.
    if (name.starts_with("base/picture_files/")) continue;
    constexpr std::array<const char*, 6> kDecoders{"imdecode(",   "imread(",           "decode_picture_file(",
                                                   "decode_png(", "decode_jpeg_file(", "decode_upright_picture("};
    if (std::ranges::none_of(kDecoders, [&](const char* call) { return text.find(call) != std::string::npos; }))
      continue;
    decoders.push_back(name);
    if (text.find("picture_header(") == std::string::npos) found.push_back(name);
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GE(decoders.size(), 5u);
}

// What a reader leaves out of a model must reach whoever brought it: whatever reads one hands its notes on.
// (tests/pipeline/lab/look runs the commands.)
TEST(Reading, NoModelIsReadWithoutItsNotes) {
  std::vector<std::string> readers, found;
  for (const auto& [name, text] : texts_ending_in(repository_files(), {".cpp", ".hpp"})) {
    if (!name.starts_with("pipeline/") || text.find("read_gltf(") == std::string::npos) continue;
    readers.push_back(name);
    if (text.find("notes") == std::string::npos) found.push_back(name);
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GE(readers.size(), 4u);
}

}  // namespace
}  // namespace kasumi::house
