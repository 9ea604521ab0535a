// The checks of one random model, and of a batch of them as emitted C++. A failure is a text whose part before the
// first colon names its kind; empty means none.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bip/image.hpp"
#include "tools/gen/description.hpp"
#include "tools/gen/engine_runs.hpp"

namespace bip::gen {

struct CheckOptions {
  std::uint64_t steps = 60;
  bool jit = true;
  bool emit_cpp = false;
  std::uint64_t engine_runs = 0;  // not 0: so many runs of the engines with several threads, and no other check
  std::string source_dir;         // the project's root, for emitted C++
  std::string runtime_lib;        // libbip_runtime.a
  std::string work_dir;           // for emitted C++
  std::string cxx_flags;          // those of this build's sanitizers
};
struct OracleCounts {
  std::uint64_t states = 0, too_large = 0;
};
struct Counts {
  OracleCounts oracle;
  std::uint64_t in_columns = 0;  // systems whose loop over steps has data in columns
  EngineCounts engines;
};

/// A sound model on its way into a batch of emitted C++.
struct EmittedCase {
  std::uint64_t seed = 0;
  std::string source;  // one namespace, m<seed>
  std::vector<std::string> traces;
};

/// The seed's model; the plain one if the compiler says of the full one that it is not supported yet (B1900).
struct SupportedModel {
  Description model;
  bool is_plain = false;
};
[[nodiscard]] SupportedModel supported_model(std::uint64_t seed);

/// Compiles the text, runs the interpreter, the JIT at both levels and the naive oracle, round-trips .bsys and fmt.
/// Fills `emitted` if it is not null and the model is sound.
[[nodiscard]] std::string check_model(const Description& model, std::uint64_t seed, const CheckOptions& options,
                                      Counts& counts, EmittedCase* emitted);

/// Compiles all cases as one program and compares traces, or makes its runs. One row a failing case.
struct Failure {
  std::uint64_t seed = 0;
  std::string what;
};
[[nodiscard]] std::vector<Failure> check_emitted(const std::vector<EmittedCase>& cases, const CheckOptions& options,
                                                 const std::string& name, EngineCounts& counts);

/// States and candidates against the naive oracle. The image must have code.
[[nodiscard]] std::string check_naive(const Description& model, const rt::Image& image, std::uint64_t seed,
                                      std::uint64_t steps, OracleCounts& counts);

/// "first difference at line 3: `a` against `b`"
[[nodiscard]] std::string first_difference(const std::string& a, const std::string& b);

}  // namespace bip::gen
