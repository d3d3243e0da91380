// A recording played as a camera, with faults that a test switches on and off.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "capture/reconnecting_source.hpp"

namespace kasumi {

// Where a thread gets stuck until a test lets it go.
class Trap {
 public:
  void set() { set_ = true; }
  bool is_set() const { return set_; }
  // BLOCKS while it is set, as a system call that never returns.
  void enter();
  bool caught() const { return caught_; }
  void let_go();

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  std::atomic<bool> set_ = false, caught_ = false;
};

// Read by the source at each call. One thread, but for `trap`.
struct CameraFaults {
  bool unplugged = false;
  int opened = 0;
  std::string open_fails;                    // the driver's message; empty: it opens
  bool silent = false;                       // streaming, but no frame comes
  Trap trap;                                 // the next call never returns
  bool fatal_queue = false;                  // the next call fails, once
  std::function<void(Frame&)> spoil;         // each frame; empty: as recorded
  std::function<void(std::uint32_t)> gives;  // called with the recorded number of each good frame
};

// `opener` of a good camera; `faults` must outlive it.
SourceOpener with_faults(SourceOpener opener, CameraFaults& faults, Clock& clock);

// Ways to spoil a frame.
void flag_as_error(Frame& frame);
void truncate(Frame& frame);  // half of the bytes
void empty(Frame& frame);     // bytes_used 0
void replace_by_rubbish_jpeg(Frame& frame);
std::function<void(Frame&)> freeze();         // the first frame's bytes again and again
void cover(Frame& frame);                     // black
void white_out(Frame& frame);                 // white
void cloud_over(Frame& frame);                // nothing is bright, the sun neither
void halve_size(Frame& frame);                // as if another mode had been negotiated
std::function<void(Frame&)> lend();           // no fault: in a buffer that others can read, as drivers export them
std::function<void(Frame&)> run_backwards();  // timestamps that jump back, sequence numbers with gaps

}  // namespace kasumi
