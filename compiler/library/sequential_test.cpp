// See sequential_test.hpp.
#include "compiler/library/sequential_test.hpp"

#include <cmath>

#include "runtime/include/bip/assert.hpp"

namespace bip::library {

// H0: share + delta, H1: share - delta; the ratio is that of H1's likelihood to H0's.
SequentialTest::SequentialTest(double share, const TestOptions& options) {
  const double high = share + options.delta, low = share - options.delta;
  BIP_ASSERT(low > 0 && high < 1 && low < high, "a test of {} +- {}", share, options.delta);
  of_success_ = std::log(low / high);
  of_failure_ = std::log((1 - low) / (1 - high));
  yes_below_ = std::log(options.beta / (1 - options.alpha));
  no_above_ = std::log((1 - options.beta) / options.alpha);
}

SequentialTest::Verdict SequentialTest::add(bool is_success) {
  ++trials_;
  ratio_ += is_success ? of_success_ : of_failure_;
  return ratio_ <= yes_below_ ? Verdict::Yes : ratio_ >= no_above_ ? Verdict::No : Verdict::Open;
}

}  // namespace bip::library
