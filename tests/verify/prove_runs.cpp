// bip-prove-runs [--finite | --neighbourhoods] FILE [SECONDS [ROUNDS [CERTIFICATE]]]: properties of runs of a model,
// each asked of the circuit alone (compiler/verify/liveness/k_liveness.hpp; --finite: finite_moves.hpp), or of
// neighbourhoods (neighbourhood_runs.hpp). Reads lines "FAIRNESS PROPERTY"; prints for each `holds ROUNDS ATOMS`,
// `holds CASES NEIGHBOURS`, or `unknown REASON`. With CERTIFICATE that of the proof of line N is written to
// the file CERTIFICATE.N; the proof is then another one. test_liveness.py compares the answers with its oracle.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>

#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/liveness/finite_moves.hpp"
#include "compiler/verify/liveness/neighbourhood_runs.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

constexpr std::size_t kMegabytes = 2048;

void print_proof_by_neighbourhoods(const verify::Formula& formula, const System& system, const rt::Image& image,
                                   const verify::RunCircuit& circuit, const verify::KLivenessOptions& asked) {
  if (!verify::has_neighbourhoods(system, image)) {
    std::printf("unknown no neighbourhoods\n");
    return;
  }
  verify::NeighbourhoodOptions options;
  options.fairness = asked.fairness;
  options.cancellation = asked.cancellation;
  options.never_ends = [&] {
    return circuit.problem.empty() && verify::is_never(circuit, circuit.machine.ended, asked.cancellation);
  };
  const verify::NeighbourhoodProof proof = verify::prove_by_neighbourhoods(formula, system, image, options);
  if (proof.is_proved) std::printf("holds %u %u\n", proof.cases, proof.neighbours);
  else std::printf("unknown a case stays open\n");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string engine = argc > 1 && std::string(argv[1]).starts_with("--") ? argv[1] : "";
  const bool is_finite = engine == "--finite", is_local = engine == "--neighbourhoods";
  if (is_finite || is_local) {
    --argc;
    ++argv;
  }
  if (argc < 2 || argc > 5) {
    std::fprintf(stderr, "bip-prove-runs [--finite | --neighbourhoods] FILE [SECONDS [ROUNDS [CERTIFICATE]]]\n");
    return 2;
  }
  const double seconds = argc > 2 ? std::strtod(argv[2], nullptr) : 5;
  // More rounds than a small system needs.
  const auto most_rounds = static_cast<std::uint32_t>(argc > 3 ? std::strtoul(argv[3], nullptr, 10) : 16);
  std::ifstream file(argv[1]);
  std::ostringstream text;
  text << file.rdbuf();
  const gen::Compiled c = gen::compile_texts({text.str()});
  if (!c.problem.empty()) {
    std::fprintf(stderr, "%s: %s\n", argv[1], c.problem.c_str());
    return 1;
  }
  const verify::PropertyReader reader(*c.system);
  std::string line;
  std::size_t count = 0;
  while (std::getline(std::cin, line)) {
    const std::size_t blank = line.find(' ');
    const Result<verify::Fairness> fairness = verify::read_fairness(line.substr(0, blank), *c.system);
    Result<verify::ParsedProperty> parsed = reader.read(line.substr(std::min(blank + 1, line.size())));
    if (!fairness || !parsed || parsed->form != verify::PropertyForm::Runs) {
      std::fprintf(stderr, "%s: no property of runs\n", line.c_str());
      return 2;
    }
    verify::KLivenessOptions options;
    options.fairness = *fairness;
    options.most_rounds = most_rounds;
    options.wants_certificate = argc > 4;
    options.cancellation = verify::within_seconds(seconds);
    const rt::Image& image = c.lowered->image;
    const verify::RunCircuit circuit = verify::make_run_circuit(*c.system, image, kMegabytes, options.cancellation);
    if (is_local) {
      print_proof_by_neighbourhoods(parsed->formula, *c.system, image, circuit, options);
      continue;
    }
    const verify::KLivenessProof proof =
        is_finite ? verify::prove_by_finite_moves(parsed->formula, *c.system, image, circuit, options)
                  : verify::prove_by_k_liveness(parsed->formula, *c.system, image, circuit, options);
    if (proof.outcome == verify::Outcome::Holds) std::printf("holds %u %u\n", proof.rounds, proof.atoms);
    else std::printf("unknown %s\n", proof.reason.c_str());
    if (argc > 4 && proof.outcome == verify::Outcome::Holds)
      std::ofstream(argv[4] + ('.' + std::to_string(count)))
          << verify::certificate_of_runs(parsed->formula, *fairness, proof.rows, *c.system, "Root()").value_or("");
    ++count;
  }
  return 0;
}
