#include "base/picture_files/rare_files.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

namespace kasumi {

namespace {

constexpr const char* kModule = "kasumi-rare-files.so";
constexpr const char* kEntry = "kasumi_rare_files";

std::filesystem::path place_of_module() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto beside = folder / kModule;
  return std::filesystem::exists(beside, error) ? beside : folder.parent_path() / "lib/kasumi" / kModule;
}

Result<const RareFiles*> load() {
  const auto file = place_of_module();
  const auto cannot = [&](const char* why) {
    return fail(FaultKind::unsupported, "films and pictures other than PNG and JPEG: {}", why);
  };
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // kept until the program ends
  if (!module) return cannot(dlerror());
  void* entry = dlsym(module, kEntry);
  if (!entry) return cannot(dlerror());
  return reinterpret_cast<const RareFiles* (*)()>(entry)();
}

}  // namespace

Result<const RareFiles*> rare_files() {
  static const Result<const RareFiles*> kLoaded = load();
  return kLoaded;
}

}  // namespace kasumi
