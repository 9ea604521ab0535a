// What is written about a run: one line a step in three formats (semantics.md has them exactly). Functions append to a
// string; nothing here decides anything, nothing depends on the clock.
#pragma once
#include <string>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/trace/future.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

[[nodiscard]] const char* name_of(End end);        // "deadlock"
[[nodiscard]] const char* name_of(Engine engine);  // "threads"

/// For candidates whose number is not known.
inline constexpr std::uint64_t kNoChoice = ~std::uint64_t{0};

/// The candidate's name: the connector's path, or atom.port.
void append_candidate(std::string& out, const Core& core, const Candidate& candidate);
/// The same of an interaction that was fired.
void append_interaction(std::string& out, const Core& core, InteractionId interaction);
/// A value as JSON has it; what JSON has no word for, quoted.
void append_json_value(std::string& out, const Image& image, CellType type, Cell value);
/// `{"v":1}`: what a port shows.
void append_json_values(std::string& out, const Core& core, u32 atom, u32 port);
/// A fault's members at the end of an object: its code and message.
void append_json_fault(std::string& out, const Core& core);
/// Where a step stands on a time line, in ns: its instant; without time a millisecond a step.
[[nodiscard]] i64 instant_of_step(const Core& core, std::uint64_t number);

/// All writers take the state before the step.
class StepWriter {
 public:
  /// `bipc: seed 42, policy uniform`
  void begin(std::string& out, const TraceHead& head);
  /// `#3  ROOT.k  p.put(v=1) c.get(v=0)`
  void step(std::string& out, Core& core, const Candidate& candidate, std::uint64_t number);
  /// Every candidate of the state, indented.
  void state(std::string& out, Core& core);

 private:
  void append_ports(std::string& out, Core& core, const Candidate& candidate);
  void append_values(std::string& out, const Core& core, u32 atom, u32 port);
  std::vector<Participant> participants_;
};

/// The published engine's own lines.
class Bip2Writer final : public TraceSink {
 public:
  void begin(std::string& out, const TraceHead& head) override;
  /// The state's candidates.
  void state(std::string& out, Core& core, std::uint64_t number) override;
  /// The state and the choice; with time as they were when foresee() was called.
  void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override;
  /// Images with time: notes the state's candidates now and later, before time passes.
  void foresee(Core& core) override;
  /// The state alone, with the intervals; for readers that take no step.
  void future_state(std::string& out, std::uint64_t number) const;
  [[nodiscard]] bool has_future() const { return !future_.empty(); }
  /// After a fault first `ERROR: invariant ROOT.a.i violated!`, if the published engine knows such a fault.
  void end(std::string& out, const Core& core, End end, std::uint64_t number) override;

 private:
  void choice(std::string& out, Core& core, std::uint64_t k);
  void foreseen(std::string& out, Core& core, std::uint64_t number, const Candidate& chosen);
  void fault(std::string& out, const Core& core);
  void append(std::string& out, Core& core, std::uint64_t k);
  void append_body(std::string& out, Core& core, const Candidate& candidate);
  void append_foreseen(std::string& out, std::size_t k) const;
  std::vector<Participant> participants_;
  std::vector<FutureCandidate> future_;
  i64 foreseen_at_ = 0;
  bool is_interactive_ = false;
};

/// JSON lines, version 1.
class JsonWriter final : public TraceSink {
 public:
  void begin(std::string& out, const TraceHead& head) override;
  /// k == kNoChoice: neither it nor the number of candidates is written.
  void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override;
  void end(std::string& out, const Core& core, End end, std::uint64_t steps) override;

 private:
  /// What a step of an interaction writes: all after the number of candidates, values left out, or, if who takes part
  /// differs, the name.
  struct Line {
    std::string text;                 // if it is whole with some room behind it
    u32 first_value = 0, values = 0;  // rows of values_
    bool is_whole = false;
  };
  /// Of a variable of a port: it comes before the character `at`.
  struct Value {
    u32 at, atom, port, variable;
    VariableId id;  // without time
    CellType type;
  };
  void begin_lines(const Core& core);
  void begin_line(Line& line, Core& core, const Candidate& candidate);
  void append_ports(std::string& out, Core& core, const Candidate& candidate);
  std::vector<Participant> participants_;
  // Text that comes again, made when it comes first: a writer is for one image.
  IndexVector<InteractionId, Line> lines_;
  std::vector<Value> values_;
  std::vector<std::string> ports_;      // by port instance, for lines that are not whole
  std::vector<std::string> variables_;  // by first_variable_ of a port type + variable: the quoted name and a colon
  std::vector<u32> first_variable_;
};

}  // namespace bip::rt
