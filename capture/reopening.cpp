#include "capture/reconnecting_source.hpp"

namespace kasumi {

namespace {

// A source that outlives its openings, and the frame that was read when checking whether it is present.
struct Lasting {
  std::unique_ptr<FrameSource> source;
  std::optional<Frame> waiting;
  Clock& clock;

  bool present() {
    if (waiting) return true;
    auto frame = source->next(clock.now());
    if (!frame) return frame.error().kind != FaultKind::disconnected;
    waiting = std::move(*frame);
    return true;
  }
};

class Opening final : public FrameSource {
 public:
  explicit Opening(std::shared_ptr<Lasting> lasting) : lasting_(std::move(lasting)) {}
  std::string description() const override { return lasting_->source->description(); }
  Result<Frame> next(Instant deadline) override {
    if (!lasting_->waiting) return lasting_->source->next(deadline);
    Frame frame = std::move(*lasting_->waiting);
    lasting_->waiting.reset();
    return frame;
  }

 private:
  std::shared_ptr<Lasting> lasting_;
};

}  // namespace

SourceOpener reopening(std::string name, std::unique_ptr<FrameSource> source, Clock& clock) {
  const auto lasting = std::make_shared<Lasting>(Lasting{std::move(source), std::nullopt, clock});
  SourceOpener opener;
  opener.name = std::move(name);
  opener.present = [lasting] { return lasting->present(); };
  opener.open = [lasting]() -> Result<std::unique_ptr<FrameSource>> {
    if (!lasting->present()) return fail(FaultKind::disconnected, "{}: disconnected", lasting->source->description());
    return std::make_unique<Opening>(lasting);
  };
  return opener;
}

}  // namespace kasumi
