// Whose folder it is. Root does not write into a folder of somebody else's under its own name: links may have been
// planted there.
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
  bool other = false;  // than ours: to be changed to
  std::string name;
};

// Who is to write into a folder: its owner, if we are root, or the service's account for a folder of root's; else we.
Account account_for(const struct stat& folder);
// For ever, in this process or a child of one with threads. false: errno says why not.
bool change_to(const Account& account);

// If we are root and the folder, or the first above it that is there, is somebody else's, we are them from now on.
// Error: io.
Result<> become_owner_of(std::filesystem::path folder);

}  // namespace kasumi
