// Signatures against minisign itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sodium.h>

#include "pipeline/kiosk/content/signature.hpp"
#include "tests/pipeline/kiosk/content/bundles.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class Minisign : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_minisign()) GTEST_SKIP() << "minisign is not installed";
    folder = content_folder(testing::UnitTest::GetInstance()->current_test_info()->name());
    make_keys(folder, "curator");
    keys = read_public_keys(folder / "keys").value();
    ASSERT_TRUE(write_text_file(folder / "text", text));
  }
  // What minisign signs.
  std::string signed_by(const std::string& key, const std::string& options = {}) {
    EXPECT_EQ(shell(fmt::format("minisign -S {} -s {}/{}.key -m {}/text -t 'spring, the second try'", options,
                                folder.string(), key, folder.string())),
              0);
    return read_text_file(folder / "text.minisig").value();
  }
  std::filesystem::path folder;
  std::vector<PublicKey> keys;
  std::string text = "what is signed\nin two lines\n";
};

std::string why(const Result<Signed>& verified) {
  return verified ? "verified" : verified.error().message;
}

TEST_F(Minisign, WhatItSignsIsAccepted) {
  for (const char* way : {"", "-l"}) {  // prehashed, and as older versions sign
    const auto verified = verify_signature(text, signed_by("curator", way), keys);
    ASSERT_TRUE(verified) << way << ": " << verified.error().message;
    EXPECT_EQ(verified->by, "curator");
    EXPECT_EQ(verified->comment, "spring, the second try");
  }
}

TEST_F(Minisign, AcceptsWhatIsSignedHere) {
  const auto key = read_secret_key(read_text_file(folder / "curator.key").value(), {}).value();
  ASSERT_TRUE(write_text_file(folder / "text.minisig", sign(text, key, "by hand, 2026").value()));
  const auto verify = fmt::format("minisign -V -p {0}/keys/curator.pub -m {0}/text", folder.string());
  EXPECT_EQ(shell(verify), 0);
  ASSERT_TRUE(write_text_file(folder / "text", text + " "));
  EXPECT_NE(shell(verify), 0) << "it looks at what was signed";
}

TEST_F(Minisign, AKeyWithAPasswordOpensWithItAlone) {
  const auto secret = folder / "locked.key";
  ASSERT_EQ(shell(fmt::format("printf 'plum\\nplum\\n' | minisign -G -f -p {0}/keys/locked.pub -s {0}/locked.key",
                              folder.string())),
            0);
  const auto file = read_text_file(secret).value();
  // A wrong password unlocks nothing; under a cheap derivation, which is as wrong, since a real one takes seconds.
  auto cheap = file;
  const auto at = cheap.find('\n') + 1;
  std::string bytes(158, '\0');
  ASSERT_EQ(sodium_base642bin(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), cheap.data() + at,
                              cheap.size() - at - 1, "\n", nullptr, nullptr, sodium_base64_VARIANT_ORIGINAL),
            0);
  for (const std::size_t field : {38u, 46u}) bytes.replace(field, 8, std::string("\0\0\0\1\0\0\0\0", 8));
  std::string text64(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text64.data(), text64.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  cheap = cheap.substr(0, at) + text64.c_str() + "\n";
  const auto wrong = read_secret_key(cheap, [] { return Result<std::string>("pear"); });
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("password"));
  const auto key = read_secret_key(file, [] { return Result<std::string>("plum"); });
  ASSERT_TRUE(key) << key.error().message;
  ASSERT_TRUE(write_text_file(folder / "text.minisig", sign(text, *key, "").value()));
  EXPECT_EQ(shell(fmt::format("minisign -V -p {0}/keys/locked.pub -m {0}/text", folder.string())), 0);
}

TEST_F(Minisign, AnyChangedByteIsNoticed) {
  const auto good = signed_by("curator");
  EXPECT_THAT(why(verify_signature(text + " ", good, keys)), HasSubstr("changed since"));
  std::size_t tried = 0;
  const auto first_line = good.find('\n');  // which is not signed
  for (std::size_t at = first_line + 1; at < good.size(); ++at) {
    auto bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    if (bad[at] == '\r' || good[at] == '\n') continue;
    EXPECT_FALSE(verify_signature(text, bad, keys)) << at << ": " << bad;
    ++tried;
  }
  EXPECT_GT(tried, 150u);
}

TEST_F(Minisign, AnotherKeyIsNamed) {
  make_keys(folder, "stranger");
  const auto by_stranger = signed_by("stranger");
  EXPECT_THAT(why(verify_signature(text, by_stranger, keys)),
              testing::AllOf(HasSubstr("not trusted here"), HasSubstr("curator")));
  EXPECT_THAT(why(verify_signature(text, by_stranger, {})), HasSubstr("trusted: none"));
  EXPECT_EQ(why(verify_signature(text, "", keys)), "it is not signed");
  // The stranger's key under the curator's number.
  auto forged = read_public_keys(folder / "keys").value();
  ASSERT_EQ(forged.size(), 2u);
  forged[1].id = keys[0].id;
  EXPECT_TRUE(verify_signature(text, signed_by("curator"), forged)) << "all keys of that number are tried";
}

TEST(Signature, NonsenseIsRefused) {
  for (const char* nonsense : {"x", "untrusted comment: \n\ntrusted comment: \n\n", "\n\n\n\n",
                               "untrusted comment: a\nRWQ=\ntrusted comment: b\nRWQ=\n"})
    EXPECT_THAT(why(verify_signature("text", nonsense, {})), HasSubstr("four lines")) << nonsense;
  EXPECT_FALSE(read_public_key("untrusted comment: x\nRWQ=\n", "x"));
  EXPECT_FALSE(read_secret_key("untrusted comment: x\nRWQ=\n", {}));
  EXPECT_TRUE(read_public_keys("/no such folder").value().empty());
  const auto folder = content_folder("no-keys");
  ASSERT_TRUE(write_text_file(folder / "a.pub", "x"));
  ASSERT_TRUE(write_text_file(folder / "b.pub", ""));
  const auto keys = read_public_keys(folder);
  ASSERT_FALSE(keys);
  EXPECT_THAT(keys.error().message, testing::AllOf(HasSubstr("a.pub"), HasSubstr("b.pub"))) << "all at once";
}

}  // namespace
}  // namespace kasumi
