// The glTF extensions, and how Kasumi treats each. For this room's glTF sources only.
#pragma once

#include <string_view>

namespace kasumi {

enum class ExtensionUse {
  read,      // as it is meant
  without,   // the building shows without it, and something is missing
  metadata,  // nothing of it is to be seen
  unknown,   // a file that only uses it may show wrongly; one that requires it is refused
};
struct ExtensionNote {
  ExtensionUse use = ExtensionUse::unknown;
  std::string_view text;  // without: what is missing; unknown: what the owner can do
};
ExtensionNote extension_note(std::string_view extension);

}  // namespace kasumi
