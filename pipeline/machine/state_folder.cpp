#include "pipeline/machine/state_folder.hpp"

#include <cerrno>
#include <cstring>

#include <unistd.h>

#include "pipeline/machine/disk_probe.hpp"

namespace kasumi {
namespace {

constexpr const char* kServiceFolder = "/var/lib/kasumi";  // StateDirectory= of the unit
constexpr std::size_t kTriedBytes = 4096;

}  // namespace

Result<std::string> try_state_folder(const std::filesystem::path& folder) {
  const auto name = "[state] folder = \"" + folder.string() + "\"";
  std::error_code error;
  if (!std::filesystem::exists(folder, error)) {
    if (folder.lexically_normal() == kServiceFolder) return name + " is not there yet: the service makes it";
    return fail(FaultKind::bad_input,
                "{}: there is no such folder: expected one that the service may write: sudo install -d -o kasumi -g "
                "kasumi {}",
                name, folder.string());
  }
  if (!std::filesystem::is_directory(folder, error))
    return fail(FaultKind::bad_input, "{}: expected a folder, this is none", name);
  const auto probe = probe_disk(folder, kTriedBytes);
  if (!probe) return fail(FaultKind::io, "{}: {}", name, probe.error().message);
  if (probe->error == 0) return std::string();
  if (probe->error == EACCES && ::geteuid() != 0)
    return name + " was not tried: this user may not write it; sudo kasumi run --config FILE --check may";
  if (probe->error == EACCES)
    return fail(FaultKind::bad_input,
                "{}: {} may not write it: expected a folder of the service's: sudo chown -R "
                "kasumi:kasumi {}",
                name, probe->account, folder.string());
  if (probe->hangs) return fail(FaultKind::io, "{}: nothing was written in {:.0f} s", name, probe->seconds);
  return fail(FaultKind::io, "{}: cannot be written: {}", name, std::strerror(probe->error));
}

}  // namespace kasumi
