// Any TOML file, read for every key a configuration may contain.
#include "base/table/config_table.hpp"
#include "capture/fixture/fixture.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  const auto root = ConfigTable::parse({reinterpret_cast<const char*>(input.data()), input.size()}, "fuzzed.toml");
  expect_value_or_sentence(root);
  if (!root) return;
  read_fixture_info(*root);
  for (const auto& table : {root->table("site"), root->table("sky"), root->table("object")}) {
    table.number("number", {0.0, 10.0});
    table.integer("integer", {-5.0, 5.0}, 1);
    table.flag("flag", false);
    table.text("text");
    table.choice("choice", {"a", "b"});
    table.numbers("numbers", 0);
    table.numbers("three", 3, {-1.0, 1.0});
    table.utc("utc");
    table.optional_file("file");
    for (const auto& each : table.tables("tables")) each.number("number");
  }
  expect_value_or_sentence(root->finish());
}
