#include "pipeline/machine/television.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <optional>

#include <fcntl.h>
#include <linux/cec.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace kasumi {

namespace {

constexpr std::uint32_t kAnswer_ms = 1000;  // CEC 7.1: a device answers within a second
constexpr std::string_view kOwnName = "Kasumi";

class KernelCecDevice final : public CecDevice {
 public:
  explicit KernelCecDevice(int descriptor) : descriptor_(descriptor) {}
  KernelCecDevice(const KernelCecDevice&) = delete;
  KernelCecDevice& operator=(const KernelCecDevice&) = delete;
  ~KernelCecDevice() override { ::close(descriptor_); }
  int control(unsigned long request, void* argument) override {
    return ::ioctl(descriptor_, request, argument) == 0 ? 0 : errno;
  }

 private:
  int descriptor_;
};

tl::unexpected<Fault> cec_refused(std::string_view call, int error) {
  return fail(FaultKind::device, "{}: {}", call, std::strerror(error));
}

// This machine's address on the bus, claimed as a playback device if not claimed yet. Without a picture's connection,
// which some televisions drop in their sleep, the unregistered one, by which they can still be woken.
Result<std::uint8_t> own_address(CecDevice& adapter) {
  cec_log_addrs addresses{};
  if (const int error = adapter.control(CEC_ADAP_G_LOG_ADDRS, &addresses)) return cec_refused("its addresses", error);
  if (addresses.num_log_addrs == 0) {
    addresses = {};
    addresses.cec_version = CEC_OP_CEC_VERSION_1_4;
    addresses.vendor_id = CEC_VENDOR_ID_NONE;
    addresses.flags = CEC_LOG_ADDRS_FL_ALLOW_UNREG_FALLBACK;
    addresses.num_log_addrs = 1;
    addresses.primary_device_type[0] = CEC_OP_PRIM_DEVTYPE_PLAYBACK;
    addresses.log_addr_type[0] = CEC_LOG_ADDR_TYPE_PLAYBACK;
    addresses.all_device_types[0] = CEC_OP_ALL_DEVTYPE_PLAYBACK;
    std::ranges::copy(kOwnName, addresses.osd_name);
    if (const int error = adapter.control(CEC_ADAP_S_LOG_ADDRS, &addresses))
      return cec_refused("claiming an address", error);
  }
  if (addresses.log_addr_mask == 0 || addresses.log_addr[0] == CEC_LOG_ADDR_INVALID)
    return std::uint8_t{CEC_LOG_ADDR_UNREGISTERED};
  return addresses.log_addr[0];
}

// `reply`: the opcode that is waited for; empty: none. Returns the message as the kernel gives it back.
Result<cec_msg> transmit(CecDevice& adapter, std::uint8_t to, std::string_view what,
                         std::initializer_list<std::uint8_t> bytes, std::optional<std::uint8_t> reply = std::nullopt) {
  const auto from = own_address(adapter);
  if (!from) return fail(from.error());
  cec_msg message{};
  message.msg[0] = static_cast<std::uint8_t>(*from << 4 | to);
  std::ranges::copy(bytes, message.msg + 1);
  message.len = static_cast<std::uint32_t>(1 + bytes.size());
  if (reply) {
    message.reply = *reply;
    message.timeout = kAnswer_ms;
  }
  if (const int error = adapter.control(CEC_TRANSMIT, &message)) return cec_refused(what, error);
  if (message.tx_status & CEC_TX_STATUS_OK) return message;
  return fail(FaultKind::device, "{}: {}", what,
              message.tx_status & CEC_TX_STATUS_NACK ? "no television answers" : "the bus does not take it");
}

}  // namespace

Result<std::unique_ptr<CecDevice>> open_cec_device(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor >= 0) return std::make_unique<KernelCecDevice>(descriptor);
  return fail(errno == ENOENT || errno == ENXIO || errno == ENODEV ? FaultKind::disconnected : FaultKind::device,
              "{}: {}", path.string(), std::strerror(errno));
}

std::string_view name_of(TelevisionPower power) {
  switch (power) {
    case TelevisionPower::unknown: return "unknown";
    case TelevisionPower::on: return "on";
    case TelevisionPower::standby: return "standby";
  }
  return "";
}

Result<> wake_television(CecDevice& adapter) {
  const auto woken = transmit(adapter, CEC_LOG_ADDR_TV, "waking it", {CEC_MSG_IMAGE_VIEW_ON});
  if (!woken) return fail(woken.error());
  // Where the picture comes from: the place of this machine among the television's inputs.
  std::uint16_t place = CEC_PHYS_ADDR_INVALID;
  if (const int error = adapter.control(CEC_ADAP_G_PHYS_ADDR, &place)) return cec_refused("its place", error);
  if (place == CEC_PHYS_ADDR_INVALID) return {};  // it takes the input by which it was woken
  const auto shown =
      transmit(adapter, CEC_LOG_ADDR_BROADCAST, "choosing its input",
               {CEC_MSG_ACTIVE_SOURCE, static_cast<std::uint8_t>(place >> 8), static_cast<std::uint8_t>(place & 0xff)});
  if (!shown) return fail(shown.error());
  return {};
}

Result<> send_television_to_sleep(CecDevice& adapter) {
  const auto sent = transmit(adapter, CEC_LOG_ADDR_TV, "putting it to sleep", {CEC_MSG_STANDBY});
  if (!sent) return fail(sent.error());
  return {};
}

Result<TelevisionPower> ask_television(CecDevice& adapter) {
  const auto asked =
      transmit(adapter, CEC_LOG_ADDR_TV, "asking it", {CEC_MSG_GIVE_DEVICE_POWER_STATUS}, CEC_MSG_REPORT_POWER_STATUS);
  if (!asked) return fail(asked.error());
  if (!(asked->rx_status & CEC_RX_STATUS_OK) || asked->len < 3 || asked->msg[1] != CEC_MSG_REPORT_POWER_STATUS)
    return TelevisionPower::unknown;
  switch (asked->msg[2]) {
    case CEC_OP_POWER_STATUS_ON:
    case CEC_OP_POWER_STATUS_TO_ON: return TelevisionPower::on;
    case CEC_OP_POWER_STATUS_STANDBY:
    case CEC_OP_POWER_STATUS_TO_STANDBY: return TelevisionPower::standby;
    default: return TelevisionPower::unknown;
  }
}

}  // namespace kasumi
