// The sequential probability ratio test: is a probability at least a share? (A. Wald, Sequential Tests of Statistical
// Hypotheses, 1945; for models H. Younes, R. Simmons 2002.)
//
// Between share - delta and share + delta either answer is as good. Above it `no` is answered with probability at most
// alpha, below it `yes` with probability at most beta. The number of trials follows from what they give.
#pragma once
#include <cstdint>

namespace bip::library {

struct TestOptions {
  double alpha = 0.05, beta = 0.05;  // probabilities of the two wrong answers
  double delta = 0.01;               // half the width of the region in which either answer is good
};

class SequentialTest {
 public:
  /// Requires 0 < share - delta and share + delta < 1.
  SequentialTest(double share, const TestOptions& options);
  enum class Verdict : std::uint8_t { Open, Yes, No };
  /// One more trial. Returns Yes: at least the share; No: less.
  Verdict add(bool is_success);
  [[nodiscard]] std::uint64_t trials() const { return trials_; }

 private:
  double of_success_, of_failure_;  // what a trial adds to the logarithm of the ratio
  double yes_below_, no_above_;
  double ratio_ = 0;
  std::uint64_t trials_ = 0;
};

}  // namespace bip::library
