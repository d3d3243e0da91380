#include "pipeline/machine/account.hpp"

#include <cerrno>
#include <cstring>

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

namespace kasumi {

namespace {

constexpr const char* kServiceAccount = "kasumi";

}  // namespace

Account account_for(const struct stat& folder) {
  Account account{::geteuid(), ::getegid(), false, {}};
  if (account.user == 0) {
    account.user = folder.st_uid;
    account.group = folder.st_gid;
    if (const auto* service = account.user == 0 ? ::getpwnam(kServiceAccount) : nullptr) {
      account.user = service->pw_uid;
      account.group = service->pw_gid;
    }
    account.other = account.user != 0;
  }
  const auto* entry = ::getpwuid(account.user);
  account.name = entry ? entry->pw_name : fmt::format("user {}", account.user);
  return account;
}

bool change_to(const Account& account) {
  return ::setgroups(0, nullptr) == 0 && ::setresgid(account.group, account.group, account.group) == 0 &&
         ::setresuid(account.user, account.user, account.user) == 0;
}

Result<> become_owner_of(std::filesystem::path folder) {
  struct stat status {};
  while (::stat(folder.c_str(), &status) != 0 && errno == ENOENT && folder.has_relative_path())
    folder = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
  if (::geteuid() != 0 || status.st_uid == 0) return {};
  const auto account = account_for(status);
  if (change_to(account)) return {};
  return fail(FaultKind::io, "{}: belongs to {}, and we cannot write as them: {}", folder.string(), account.name,
              std::strerror(errno));
}

}  // namespace kasumi
