// Memory between one picture and the next.
#pragma once

namespace kasumi {

// From now on what a picture took stays with the process for the next one: by default the kernel takes the maps of each
// back and clears them again for the next, a sixth of the time of a picture. A picture takes some 10 MB.
void keep_freed_memory();

}  // namespace kasumi
