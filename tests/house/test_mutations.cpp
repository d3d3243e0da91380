// tests/mutations/list.toml breaks lines on purpose: each is still there, once, and so are the tests that are to notice.
#include <gtest/gtest.h>

#include <toml++/toml.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi;
using namespace kasumi::house;

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string text_of(const std::string& name) {
  return read_text_file(source_folder() / name).value();
}

TEST(Mutations, BreakLinesThatAreThere) {
  const auto list = toml::parse_file((source_folder() / "tests/mutations/list.toml").string());
  const auto* mutations = list["mutation"].as_array();
  ASSERT_TRUE(mutations);
  EXPECT_GE(mutations->size(), 50u);
  for (const auto& entry : *mutations) {
    const auto& mutation = *entry.as_table();
    const auto text = [&](const char* key) { return mutation[key].value_or(std::string()); };
    EXPECT_EQ(count_of(text_of(text("file")), text("from")), 1u) << text("file") << ": " << text("promise");
    EXPECT_NE(text("from"), text("to")) << text("promise");
    ASSERT_TRUE(mutation["tests"].is_array()) << text("promise");
    EXPECT_FALSE(mutation["tests"].as_array()->empty()) << text("promise");
  }
}

}  // namespace
