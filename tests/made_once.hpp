// What tests generate and then only read, made once for all test programs and all builds of a checkout: in
// build-made-once/, in a folder named after a hash of the generator's sources (cmake/made_once.cmake), so that another
// generator makes everything anew.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace kasumi {

// The folder that `make` filled for `description`, which must tell everything that its contents depend on; `make` is
// called unless an earlier test has done so, and returns false if it failed. Callers must not change what they find.
// Of several processes that want the same folder, one makes it and the others wait. Empty: `make` failed. The folder
// `name` is for people who look.
std::filesystem::path made_once(const std::string& name, const std::string& description,
                                const std::function<bool(const std::filesystem::path&)>& make);

// Where all that lies, and the generator's tables of skies (fixtures/light/kept_tables.hpp). What another generator made
// is removed when nothing has looked there for a week.
std::filesystem::path made_once_store();

}  // namespace kasumi
