// Translates module descriptions to BIP over stdlib/genom, as text that people read and change. compiler/docs/genom.md
// defines the translation, element by element.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/module.hpp"

namespace bip::genom {

/// What a codel has to itself while it runs: all data of its module, or the data that it uses.
enum class LockGranularity : std::uint8_t { ByGeneration, Module, Codel };

/// The decisional level, which requests services and gets replies: any request at any time; C++ functions; clients of
/// `bipc serve`.
enum class Executive : std::uint8_t { Anybody, Cpp, Served };

/// Where codels run: with the engine, or those of each module in a process of its own (bip/codel_processes.hpp).
struct Processes {
  bool are_own = false;
  std::int64_t kill_after_us = 0;  // a codel that takes so much longer than its budget is ended; 0: none is
  std::int64_t memory_mb = 0;      // of each; 0: no limit
};

/// How a module waits for what it interrupts, and how its timers tick. `First` and `Repaired` are the designs of the
/// paper's Section V-A before and after Figure 11: the message box waits, in `abtI`, until what a request interrupts
/// has ended. First: all timers of a module tick together, which deadlocks. Ours: the new activity waits, in `init`.
enum class Design : std::uint8_t { Ours, First, Repaired };

struct GenerateOptions {
  Flavour flavour = Flavour::Verification;
  Executive executive = Executive::Anybody;  // another one: execution flavour
  bool has_task_threads = false;             // codels run beside the engine, and their tasks wait for them; served only
  bool calls_c = false;                      // codels are genom3's C functions (c_codels.hpp)
  std::vector<std::string> c_sources;        // and these are their files
  Processes processes;                       // of codels; execution flavour only
  std::string package;                       // of the execution flavour also the stem of its C++ files
  std::vector<std::string> sources;          // file names, for the first comment
  LockGranularity lock = LockGranularity::ByGeneration;
  Design design = Design::Ours;
  Constraints constraints;   // of the functional level; services and posters by index
  std::int64_t tick_us = 0;  // 0: the clock of GenoM 2 modules, the greatest unit that divides all periods of GenoM 3
  std::int64_t control_period = 1;  // ticks between two looks at the message box
  std::int64_t poster_period = 1;   // ticks between two steps of PosterAge
  std::int64_t oldest = 100;        // where PosterAge stops
};

/// A tick in microseconds if no option gives it: the greatest unit that divides all periods; 10 ms if there
/// are none. GenoM 2 counts in its own clock.
[[nodiscard]] std::int64_t tick_of(const std::vector<Module>& modules);

/// One package: the types of each module, and the compound `FunctionalLevel` with all of them, the semaphore and the
/// master timer. Modules are resolved and free of errors.
[[nodiscard]] std::string generate(const std::vector<Module>& modules, const GenerateOptions& options);

/// Execution flavour: PACKAGE_codels.hpp declares what the package calls; PACKAGE_codels.cpp is a beginning of it,
/// which compiles.
[[nodiscard]] std::string codel_header(const std::vector<Module>& modules, const GenerateOptions& options);
[[nodiscard]] std::string codel_source(const std::vector<Module>& modules, const GenerateOptions& options);

}  // namespace bip::genom
