// What is left to do in libcamera's thread before an object of that thread goes.
#pragma once

#include <functional>

#include <libcamera/base/object.h>

namespace kasumi {

// Runs `last` in the thread in which this object (a camera, say) does its work: between two tasks, after all that are
// queued there now. Does not wait for it. If the thread has ended, `last` never runs.
void run_after_queued_tasks(const libcamera::Object& object, std::function<void()> last);

}  // namespace kasumi
