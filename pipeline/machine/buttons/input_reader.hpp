// Buttons, keypads, knobs and touch screens of the kernel, as what a visitor's hand does. Devices come and go; whatever
// one sends costs a bounded time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "pipeline/machine/buttons/input_device.hpp"
#include "pipeline/site/visitor/visitor_options.hpp"

namespace kasumi {

constexpr std::size_t kMostInputEvents = 64;  // of one device that one call reads; what its driver cannot keep is lost

struct InputDeviceState {
  std::filesystem::path path;
  std::string name;  // as it calls itself; empty: not known
  bool up = false;
  std::string problem;     // why it is not up; empty: it is, or was not tried yet
  std::uint64_t lost = 0;  // how often the driver has thrown events away
  std::uint64_t opened = 0;
};

class InputReader {
 public:
  using Opener = std::function<Result<std::unique_ptr<InputDevice>>(const std::filesystem::path&)>;
  // `clock` must outlive it.
  InputReader(VisitorOptions options, Opener opener, Clock& clock);
  ~InputReader();

  // What has happened since the last call. Opens what is missing, once a second, and takes it for itself, so that its
  // keys reach no other program.
  std::vector<HandEvent> read();
  // BLOCKS until the first device that is open has events, for at most `longest`.
  void wait(Duration longest);
  std::vector<InputDeviceState> devices() const;

 private:
  struct Device;
  void open(Device& device);
  void read(Device& device, std::vector<HandEvent>& events);
  void lose(Device& device, int error, std::vector<HandEvent>& events);
  void take(Device& device, const input_event& event, std::vector<HandEvent>& events);
  void take_key(Device& device, int code, bool down);
  void settle(Device& device, std::vector<HandEvent>& events);
  void resynchronize(Device& device, std::vector<HandEvent>& events);

  VisitorOptions options_;
  Opener opener_;
  Clock& clock_;
  std::vector<std::unique_ptr<Device>> devices_;
};

}  // namespace kasumi
