// SIGINT and SIGTERM as a flag that loops poll.
#pragma once

namespace kasumi {

// Installs the handlers on the first call; from then on the signals do not end the process.
bool stop_requested();

}  // namespace kasumi
