// SIGINT and SIGTERM as a question the loops ask.
#pragma once

namespace kasumi {

// From the first call on the signals no longer end the process.
bool stop_requested();

}  // namespace kasumi
