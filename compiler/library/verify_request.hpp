// What is asked of decide.hpp, without what the answer needs.
#pragma once
#include <cstdint>
#include <string>

#include "compiler/pipeline/options.hpp"
#include "compiler/verify/property/fairness.hpp"

namespace bip::library {

struct VerifyRequest {
  pipeline::Backend backend = pipeline::Backend::Auto;
  double timeout = 60;             // seconds of the processor
  double wall_timeout = 0;         // seconds of wall-clock time; 0: no limit
  std::uint64_t megabytes = 2048;  // of the states that a search keeps
  std::string property;            // empty: deadlock-freedom
  verify::Fairness fairness;       // of properties of runs
  bool partial = false;            // local deadlocks
  bool why = false;                // the invariants of the proof are part of the text
  bool stats = false;
  bool reuses = true;  // proofs from earlier runs, and leaves its own
  bool wants_certificate = false;
  bool wants_trace = false;     // of a run that breaks what was asked
  bool wants_run = false;       // as data, in the JSON
  bool all_steps = false;       // of a run that breaks what was asked, also those that it does not need
  bool is_one_of_many = false;  // a question that has no answer yet is unknown, and no error: the others are answered
};

}  // namespace bip::library
