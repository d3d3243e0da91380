#include "base/outside/loaded_module.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <string_view>
#include <system_error>

namespace kasumi {

namespace {

// Empty: the program does not know where it lies.
std::filesystem::path place_of_module(const char* file) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  const auto beside = folder / file;
  return std::filesystem::exists(beside, error) ? beside : folder.parent_path() / "lib/kasumi" / file;
}

}  // namespace

Result<const void*> loaded_module(const char* file, const std::string& entry, const char* version,
                                  const char* purpose) {
  const auto cannot = [&](const std::string& why) { return fail(FaultKind::unsupported, "{}: {}", purpose, why); };
  const auto place = place_of_module(file);
  if (place.empty()) return cannot("/proc/self/exe cannot be read");
  void* module = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module) return cannot(dlerror());
  // A package that was upgraded beneath a running program brings a module of another version.
  const auto* its = static_cast<const char*>(dlsym(module, (entry + "_version").c_str()));
  if (!its || std::string_view(its) != version)
    return cannot(fmt::format("{} is of version {}, the program of {}: start it again", place.string(),
                              its ? its : "unknown", version));
  void* found = dlsym(module, entry.c_str());
  if (!found) return cannot(dlerror());
  return reinterpret_cast<const void* (*)()>(found)();
}

}  // namespace kasumi
