// The owner of a folder. Root does not write as root into another account's folder, which may hold planted links.
#pragma once

#include <filesystem>
#include <string>

#include <sys/stat.h>
#include <sys/types.h>

#include "base/result.hpp"

namespace kasumi {

struct Account {
  uid_t user = 0;
  gid_t group = 0;
  bool other = false;  // another than this process's: to be changed to
  std::string name;
};

// The account that writes into a folder. For root: the folder's owner, or the service account for a folder of root's;
// else the current user.
Account account_for(const struct stat& folder);
// For ever, in this process or a child of one with threads. false: errno says why not.
bool change_to(const Account& account);

// If this process is root and the folder, or the nearest existing one above it, belongs to another account, switches to
// that account for good. Error: io.
Result<> become_owner_of(std::filesystem::path folder);

}  // namespace kasumi
