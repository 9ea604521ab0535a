// See interrupt_cancellation.hpp.
#include "compiler/driver/interrupt_cancellation.hpp"

namespace bip::driver {

namespace {

// What the signal handler cancels; lock-free, as handlers need it.
std::atomic<verify::CancellationSource*> interrupted_source{nullptr};

}  // namespace

extern "C" {
static void bip_cancel_on_interrupt(int) {
  if (verify::CancellationSource* source = interrupted_source.load()) source->cancel();
}
}

InterruptCancellation::InterruptCancellation() {
  interrupted_source.store(&source_);
  signals_.emplace(bip_cancel_on_interrupt);
}

InterruptCancellation::~InterruptCancellation() {
  signals_.reset();
  interrupted_source.store(nullptr);
}

}  // namespace bip::driver
