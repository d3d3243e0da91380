// A television on a CEC bus, as the kernel's adapter shows it (Documentation/userspace-api/media/cec).
#pragma once

#include <cerrno>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <sys/ioctl.h>

#include <linux/cec.h>

#include "pipeline/machine/television.hpp"

namespace kasumi {

struct FakeTelevision {
  bool there = true;       // else nobody acknowledges
  bool adapter = true;     // else there is no such file
  bool says_power = true;  // else it answers no question
  bool obeys = true;       // else it takes messages and does nothing
  bool hot_plug = true;    // the adapter knows its place
  bool on = false;
  std::uint16_t place = 0x2000;   // 2.0.0.0: its second input
  std::uint16_t active = 0xffff;  // whose picture it shows
  cec_log_addrs claimed{};
  std::vector<std::string> heard;  // messages on the bus: "40:04"
  int opened = 0;
};

class FakeCecDevice final : public CecDevice {
 public:
  explicit FakeCecDevice(FakeTelevision& television) : tv_(television) { ++tv_.opened; }
  int control(unsigned long request, void* argument) override {
    switch (request) {
      case CEC_ADAP_G_PHYS_ADDR:
        *static_cast<std::uint16_t*>(argument) = tv_.hot_plug ? tv_.place : CEC_PHYS_ADDR_INVALID;
        return 0;
      case CEC_ADAP_G_LOG_ADDRS: *static_cast<cec_log_addrs*>(argument) = current(); return 0;
      case CEC_ADAP_S_LOG_ADDRS:
        if (tv_.claimed.num_log_addrs != 0) return EBUSY;
        tv_.claimed = *static_cast<cec_log_addrs*>(argument);
        *static_cast<cec_log_addrs*>(argument) = current();
        return 0;
      case CEC_TRANSMIT: return transmit(*static_cast<cec_msg*>(argument));
      default: return ENOTTY;
    }
  }

 private:
  // A playback device gets address 4, once the adapter knows its place.
  cec_log_addrs current() const {
    auto addresses = tv_.claimed;
    const bool claims = addresses.num_log_addrs == 1 && tv_.hot_plug;
    addresses.log_addr[0] = claims ? CEC_LOG_ADDR_PLAYBACK_1 : CEC_LOG_ADDR_INVALID;
    addresses.log_addr_mask = claims ? 1U << CEC_LOG_ADDR_PLAYBACK_1 : 0;
    return addresses;
  }

  int transmit(cec_msg& message) {
    if (message.len < 2 || message.len > 16) return EINVAL;
    const int from = message.msg[0] >> 4, to = message.msg[0] & 15;
    // Without a place only the unregistered address may speak, and only to the television.
    if (!tv_.hot_plug && (from != CEC_LOG_ADDR_UNREGISTERED || to != CEC_LOG_ADDR_TV)) return ENONET;
    if (tv_.hot_plug && from != CEC_LOG_ADDR_PLAYBACK_1) return EINVAL;
    std::string heard;
    for (std::uint32_t i = 0; i < message.len; ++i) {
      char byte[4];
      std::snprintf(byte, sizeof byte, "%s%02x", i == 0 ? "" : ":", message.msg[i]);
      heard += byte;
    }
    tv_.heard.push_back(heard);
    if (!tv_.there && to != CEC_LOG_ADDR_BROADCAST) {
      message.tx_status = CEC_TX_STATUS_NACK | CEC_TX_STATUS_MAX_RETRIES;
      return 0;
    }
    message.tx_status = CEC_TX_STATUS_OK;
    const auto opcode = message.msg[1];
    if (tv_.obeys && opcode == CEC_MSG_IMAGE_VIEW_ON) tv_.on = true;
    if (tv_.obeys && opcode == CEC_MSG_STANDBY) tv_.on = false;
    if (opcode == CEC_MSG_ACTIVE_SOURCE) tv_.active = static_cast<std::uint16_t>(message.msg[2] << 8 | message.msg[3]);
    if (opcode != CEC_MSG_GIVE_DEVICE_POWER_STATUS) return 0;
    if (!tv_.says_power) {
      message.rx_status = CEC_RX_STATUS_TIMEOUT;
      return 0;
    }
    message.msg[0] = static_cast<std::uint8_t>(CEC_LOG_ADDR_TV << 4 | from);
    message.msg[1] = CEC_MSG_REPORT_POWER_STATUS;
    message.msg[2] = tv_.on ? CEC_OP_POWER_STATUS_ON : CEC_OP_POWER_STATUS_STANDBY;
    message.len = 3;
    message.rx_status = CEC_RX_STATUS_OK;
    return 0;
  }

  FakeTelevision& tv_;
};

// `television` must outlive what is opened.
inline Result<std::unique_ptr<CecDevice>> open_fake_television(FakeTelevision& television) {
  if (!television.adapter) return fail(FaultKind::disconnected, "/dev/cec0: No such file or directory");
  return std::make_unique<FakeCecDevice>(television);
}

}  // namespace kasumi
