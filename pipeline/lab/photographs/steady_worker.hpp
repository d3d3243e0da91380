// A process that works through pictures, one after the other.
#pragma once

namespace kasumi {

// From now on what a picture took stays with the process for the next one: by default the kernel takes the maps of each
// back and clears them again for the next, a sixth of the time of a picture, which takes some 10 MB. And OpenCV works in
// the thread that calls it: its own threads take more time than they save, since there is a worker for each core.
void prepare_steady_work();

}  // namespace kasumi
