// Whether what is to be read on the picture can be read there.
#pragma once

#include <string>
#include <vector>

#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

// For people, one line each: a word of a caption or of a message that no installed font can show, with the Debian package
// that can; a caption that is too long; a font file that is none. Empty: all can be read.
std::vector<std::string> words_that_cannot_be_read(const RunConfig& config);

}  // namespace kasumi
