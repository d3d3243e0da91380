// The machine's own cards, with faults injected between them and the display.
#pragma once

#include <memory>
#include <utility>

#include "gles/display/kms_system.hpp"

namespace kasumi {

class DecoratedDevice final : public KmsDevice {
 public:
  explicit DecoratedDevice(std::unique_ptr<KmsDevice> real) : real_(std::move(real)) {}
  int lost_events = 0;  // this many of the next ones never arrive

  const std::string& path() const override { return real_->path(); }
  const std::string& driver() const override { return real_->driver(); }
  int fd() const override { return real_->fd(); }
  bool has_atomic() const override { return real_->has_atomic(); }
  KmsResult<> become_master() override { return real_->become_master(); }
  bool is_master() const override { return real_->is_master(); }
  void drop_master() override { real_->drop_master(); }
  KmsResult<std::vector<KmsConnector>> connectors() override { return real_->connectors(); }
  KmsResult<KmsConnector> connector(std::uint32_t id) override { return real_->connector(id); }
  KmsConnection connection(const KmsConnector& connector) const override { return real_->connection(connector); }
  KmsResult<KmsPipe> find_pipe(const KmsConnector& connector, const KmsMode& mode) override {
    return real_->find_pipe(connector, mode);
  }
  KmsResult<std::vector<KmsPlane>> planes(const KmsPipe& pipe) override { return real_->planes(pipe); }
  KmsResult<std::uint32_t> add_framebuffer(const KmsBuffer& buffer) override { return real_->add_framebuffer(buffer); }
  void remove_framebuffer(std::uint32_t framebuffer) override { real_->remove_framebuffer(framebuffer); }
  KmsResult<> commit_mode(const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait) override {
    return real_->commit_mode(pipe, frame, wait);
  }
  KmsResult<> commit_flip(const KmsPipe& pipe, const KmsFrame& frame) override {
    return real_->commit_flip(pipe, frame);
  }
  KmsResult<> commit_planes(const KmsPipe& pipe, std::span<const KmsPlaneState> planes, std::uint64_t number,
                            KmsTrial trial) override {
    return real_->commit_planes(pipe, planes, number, trial);
  }
  KmsResult<> set_crtc(const KmsPipe& pipe, const KmsFrame& frame) override { return real_->set_crtc(pipe, frame); }
  KmsResult<> page_flip(const KmsPipe& pipe, const KmsFrame& frame) override { return real_->page_flip(pipe, frame); }
  KmsResult<> turn_off(const KmsPipe& pipe, bool atomic) override { return real_->turn_off(pipe, atomic); }
  KmsResult<std::vector<KmsEvent>> wait_events(Duration at_most) override {
    auto events = real_->wait_events(at_most);
    while (events && lost_events > 0 && !events->empty()) {
      events->erase(events->begin());
      --lost_events;
    }
    return events;
  }
  void remember(const KmsPipe& pipe) override { real_->remember(pipe); }
  void restore() override { real_->restore(); }

 private:
  std::unique_ptr<KmsDevice> real_;
};

class DecoratedSystem final : public KmsSystem {
 public:
  DecoratedDevice* last = nullptr;  // the card opened last: the display's

  std::vector<KmsCardPlace> cards() override { return real_->cards(); }
  KmsResult<std::unique_ptr<KmsDevice>> open_card(const std::string& path) override {
    auto device = real_->open_card(path);
    if (!device) return fail(device.error());
    auto decorated = std::make_unique<DecoratedDevice>(std::move(*device));
    last = decorated.get();
    return decorated;
  }
  Result<std::unique_ptr<Scanout>> open_scanout(KmsDevice& device, int width, int height) override {
    return real_->open_scanout(device, width, height);
  }
  Result<std::unique_ptr<DisplayWatch>> watch() override { return real_->watch(); }
  std::string users_of(const std::string& path) override { return real_->users_of(path); }

 private:
  std::shared_ptr<KmsSystem> real_ = open_kms_system();
};

}  // namespace kasumi
