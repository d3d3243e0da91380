#include "base/picture_files/rare_files.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace kasumi {

namespace {

constexpr const char* kModule = "kasumi-rare-files.so";
// Empty: the program does not know where it lies.
std::filesystem::path place_of_module() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  const auto beside = folder / kModule;
  return std::filesystem::exists(beside, error) ? beside : folder.parent_path() / "lib/kasumi" / kModule;
}

Result<const RareFiles*> load() {
  const auto file = place_of_module();
  const auto cannot = [&](const char* why) {
    return fail(FaultKind::unsupported, "films and pictures other than PNG and JPEG: {}", why);
  };
  if (file.empty()) return cannot("/proc/self/exe cannot be read");
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // kept until the program ends
  if (!module) return cannot(dlerror());
  // A package that was upgraded beneath a running program brings a module of another version.
  const auto* version = static_cast<const char*>(dlsym(module, "kasumi_rare_files_version"));
  if (!version || std::string_view(version) != KASUMI_VERSION)
    return cannot(fmt::format("{} is of version {}, the program of {}: start it again", file.string(),
                              version ? version : "unknown", KASUMI_VERSION)
                      .c_str());
  void* entry = dlsym(module, "kasumi_rare_files");
  if (!entry) return cannot(dlerror());
  return reinterpret_cast<const RareFiles* (*)()>(entry)();
}

}  // namespace

Result<const RareFiles*> rare_files() {
  static const Result<const RareFiles*> kLoaded = load();
  return kLoaded;
}

}  // namespace kasumi
