// The building's layer, kept over a restart: whatever a disk makes of it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/kiosk/start/file_hash.hpp"
#include "pipeline/kiosk/start/remembered_layer.hpp"
#include "tests/pipeline/kiosk/appliance/journal.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

class RememberedLayer : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    auto content = std::make_shared<Content>();
    content->config.state_folder = folder_;
    content->files = {{"/etc/kasumi/kasumi.toml", 812, 77}};
    content_ = content;
    LayerOfBefore& layer = state_.layer;
    layer.layer.box = {3, 5, 43, 29};
    layer.layer.detail = {0.7, 2, 1, 0.8, true};
    layer.layer.halves = Image<glm::u16vec4>(40, 24);
    std::uint16_t value = 0;
    for (auto& texel : layer.layer.halves.elements()) {
      ++value;
      texel = glm::u16vec4(value, 3, 2 * value, 0x3C00);
    }
    layer.sun = {0.1, -0.6, 0.79372539331937719};
    layer.turbidity = 2.4198918976247112, layer.near_ground = 1.1, layer.past_hills = 0.9;
    state_.content = content_;
    state_.utc = kThen;
  }
  Bytes saved() {
    EXPECT_TRUE(save(state_, folder_));
    return read_file(file_).value();
  }
  std::optional<LayerOfBefore> taken(Utc now = kThen + 2min) { return LayerRecall(content_, now).take(content_); }
  void expect_deleted(const Bytes& bytes, const std::string& why) {
    ASSERT_TRUE(write_file(file_, bytes));
    const Journal journal;
    EXPECT_FALSE(taken());
    EXPECT_THAT(journal.text(), testing::HasSubstr(why));
    EXPECT_FALSE(std::filesystem::exists(file_));
  }
  // With that in the place of the first line's word, and the hash that goes with it.
  static Bytes with_word(const Bytes& bytes, int number, const std::string& word) {
    const auto end = std::ranges::find(bytes, std::uint8_t{'\n'});
    std::istringstream line(std::string(bytes.begin(), end));
    std::string head, next;
    for (int i = 0; line >> next && line.peek() != EOF; ++i) head += (i > 0 ? " " : "") + (i == number ? word : next);
    FileHash hash;
    hash.add(head);
    hash.add({end + 1, bytes.end()});
    head += " " + hash.hex() + "\n";
    Bytes changed(head.begin(), head.end());
    changed.insert(changed.end(), end + 1, bytes.end());
    return changed;
  }

  static constexpr Utc kThen = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h;
  std::filesystem::path folder_ = test_folder("remembered-layer"), file_ = folder_ / "layer.bin";
  ContentPtr content_;
  LayerState state_;
};

TEST_F(RememberedLayer, ComesBackAsItWas) {
  EXPECT_FALSE(taken()) << "nothing is kept";
  saved();
  const auto back = taken();
  ASSERT_TRUE(back);
  EXPECT_EQ(back->layer.box, state_.layer.layer.box);
  EXPECT_EQ(back->layer.detail, state_.layer.layer.detail);
  EXPECT_EQ(back->layer.halves.elements(), state_.layer.layer.halves.elements());
  EXPECT_EQ(back->sun, state_.layer.sun);
  EXPECT_EQ(back->turbidity, state_.layer.turbidity);
  EXPECT_EQ(back->near_ground, state_.layer.near_ground);
  EXPECT_EQ(back->past_hills, state_.layer.past_hills);
  LayerRecall recall(content_, kThen);
  EXPECT_FALSE(recall.take(std::make_shared<Content>(*content_))) << "a reload came before the display";
}

TEST_F(RememberedLayer, OfLongAgoOrOfTimeToComeIsLeft) {
  saved();
  EXPECT_TRUE(taken(kThen + 9min));
  EXPECT_FALSE(taken(kThen + 11min));
  EXPECT_FALSE(taken(kThen - 1s));
  EXPECT_TRUE(std::filesystem::exists(file_));
}

TEST_F(RememberedLayer, Row56OfOtherContentIsDeleted) {
  for (const bool longer : {false, true}) {
    const auto bytes = saved();
    auto other = std::make_shared<Content>(*content_);
    longer ? ++other->files[0].bytes : ++other->files[0].changed_ns;
    content_ = other;
    expect_deleted(bytes, "of other content or another program");
  }
}

TEST_F(RememberedLayer, Row56ThatADiskHasDamagedIsDeleted) {
  const auto good = saved();
  for (const std::size_t left : {std::size_t{0}, std::size_t{1}, std::size_t{100}, good.size() / 2, good.size() - 1})
    expect_deleted({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(left)}, "damaged");
  auto longer = good;
  longer.push_back(0);
  expect_deleted(longer, "damaged");
  for (std::size_t at = 15; at < good.size(); at += 97)
    for (const int bit : {0, 6}) {
      auto flipped = good;
      flipped[at] ^= static_cast<std::uint8_t>(1 << bit);
      SCOPED_TRACE(at);
      expect_deleted(flipped, "damaged");
    }
  expect_deleted(Bytes(5000, '\n'), "damaged");
  expect_deleted(Bytes(5000, 'x'), "damaged");
}

// By someone who knows how to make the hash.
TEST_F(RememberedLayer, Row56WithImpossibleNumbersIsDeleted) {
  const auto good = saved();
  expect_deleted(with_word(good, 0, "kasumi-layer-2"), "of another version");
  expect_deleted(with_word(good, 0, "kasumi-lair-1"), "damaged");
  expect_deleted(with_word(good, 2, "yesterday"), "damaged");
  for (const char* size : {"0", "-7", "44", "2000000000", "99999999999999999999", "nan", "x"})
    for (const int word : {11, 12}) expect_deleted(with_word(good, word, size), "damaged");
  for (const char* corner : {"-1", "2000000000", "42"})
    for (const int word : {9, 10}) expect_deleted(with_word(good, word, corner), "damaged");
  EXPECT_EQ(with_word(good, 9, "3"), good) << "the box begins at the tenth word";
}

TEST_F(RememberedLayer, Row56ThatIsFarTooLargeIsNeitherReadNorWritten) {
  std::filesystem::remove(file_);
  ASSERT_TRUE(write_text_file(file_, "kasumi-layer-1 "));
  std::filesystem::resize_file(file_, std::uintmax_t{1} << 40);
  EXPECT_FALSE(taken());
  std::filesystem::remove(file_);
  state_.layer.layer.halves = Image<glm::u16vec4>(3000, 3000);
  EXPECT_TRUE(save(state_, folder_));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

}  // namespace
}  // namespace kasumi
