// Content that somebody brings: a bundle, or what minisign writes. What is accepted stays below its folder and is whole.
#include <string_view>

#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/signature.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

void try_minisign(std::string_view text) {
  using namespace kasumi;
  const auto key = read_public_key(text, "key");
  expect_value_or_sentence(key);
  const PublicKey known{"known", {}, {}};
  expect_value_or_sentence(verify_signature("text", text, {key.value_or(known), known}));
  expect_value_or_sentence(
      read_secret_key(text, [] { return Result<std::string>(fail(FaultKind::bad_input, "none")); }));
}

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  if (text.starts_with("untrusted comment: ")) return try_minisign(text);
  const auto bundle = look_into(scratch.file("in.kasumi", input));
  expect_value_or_sentence(bundle);
  if (!bundle) return;
  if (bundle->manifest.bytes() > (1 << 20)) return;
  const auto out = scratch.folder() / "out";
  std::filesystem::create_directories(out);
  const auto whole = check_files(*bundle);
  const auto unpacked = unpack(*bundle, out);
  if (whole.has_value() != unpacked.has_value()) std::abort();
  if (unpacked && !check_unpacked(out, bundle->manifest)) std::abort();
  std::filesystem::remove_all(out);
  // Nothing beside it.
  for (const auto& entry : std::filesystem::directory_iterator(scratch.folder()))
    if (entry.path().filename() != "in.kasumi") std::abort();
}
