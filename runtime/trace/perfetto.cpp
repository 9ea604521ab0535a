// See perfetto.hpp. Thread 0 is the track of interactions, thread k + 1 that of atom k.
#include "runtime/trace/perfetto.hpp"

#include "bip/assert.hpp"

#include "runtime/core/text.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

// ns as us.
void append_us(std::string& out, i64 ns) {
  BIP_ASSERT(ns >= 0, "the instant {}", ns);
  append_number(out, static_cast<u64>(ns / 1000));
  const i64 rest = ns % 1000;
  if (rest == 0) return;
  out += '.';
  out += static_cast<char>('0' + rest / 100);
  out += static_cast<char>('0' + rest / 10 % 10);
  out += static_cast<char>('0' + rest % 10);
}

// `,\n{"ph":"i","pid":1,"tid":3,"ts":12.5`
void append_event(std::string& out, char phase, u64 track, i64 instant) {
  out += ",\n{\"ph\":\"";
  out += phase;
  out += R"(","pid":1,"tid":)";
  append_number(out, track);
  out += R"(,"ts":)";
  append_us(out, instant);
}

void append_track(std::string& out, u64 track, const char* name) {
  out += ",\n{\"ph\":\"M\",\"pid\":1,\"tid\":";
  append_number(out, track);
  out += R"(,"name":"thread_name","args":{"name":)";
  append_quoted(out, name);
  out += "}},\n{\"ph\":\"M\",\"pid\":1,\"tid\":";
  append_number(out, track);
  out += R"(,"name":"thread_sort_index","args":{"sort_index":)";
  append_number(out, track);
  out += "}}";
}

}  // namespace

void PerfettoWriter::begin(std::string& out, const TraceHead& trace) {
  const Image& image = *trace.image;
  out += R"({"displayTimeUnit":"ns","otherData":{"model":)";
  append_quoted(out, image.name);
  out += R"(,"seed":")";
  append_number(out, trace.seed);
  out += R"(","policy":")";
  out += trace.policy;
  if (trace.draws_resumes) out += R"(","resumes":"drawn)";
  out += "\"},\"traceEvents\":[\n";
  out += R"({"ph":"M","pid":1,"name":"process_name","args":{"name":)";
  append_quoted(out, image.name);
  out += "}}";
  append_track(out, 0, "interactions");
  for (u32 atom = 0; atom < image.atoms.size; ++atom)
    append_track(out, u64{atom} + 1, image.atoms[atom].path().c_str());
  since_.assign(image.atoms.size, 0);
}

// The slice of the places that the atom is in, until now.
void PerfettoWriter::stay(std::string& out, const Core& core, u32 atom, i64 until) {
  append_event(out, 'X', u64{atom} + 1, since_[atom]);
  out += R"(,"dur":)";
  append_us(out, until - since_[atom]);
  out += R"(,"cat":"place","name":)";
  append_quoted(out, places_of(core, atom).c_str());
  out += '}';
  since_[atom] = until;
}

void PerfettoWriter::step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
                          std::uint64_t) {
  BIP_ASSERT(since_.size() == core.image().atoms.size, "begin() came before");
  const Candidate candidate = core.candidate(position);
  const i64 instant = instant_of_step(core, number);
  name_.clear();
  append_candidate(name_, core, candidate);
  std::string interaction;
  append_quoted(interaction, name_.c_str());
  append_event(out, 'i', 0, instant);
  out += R"(,"s":"t","cat":"interaction","name":)" + interaction + R"(,"args":{"step":)";
  append_number(out, number);
  out += "}}";
  core.participants(candidate, participants_);
  for (const Participant& participant : participants_) {
    const AtomType& type = core.tables().atom_type(participant.atom);
    stay(out, core, participant.atom, instant);
    append_event(out, 'i', u64{participant.atom} + 1, instant);
    out += R"(,"s":"t","cat":"port","name":)";
    append_quoted(out, type.ports[participant.port].name);
    out += R"(,"args":{"step":)";
    append_number(out, number);
    out += R"(,"interaction":)" + interaction + R"(,"values":)";
    append_json_values(out, core, participant.atom, participant.port);
    out += "}}";
  }
}

void PerfettoWriter::end(std::string& out, const Core& core, End end, std::uint64_t steps) {
  const i64 instant = instant_of_step(core, steps);
  for (u32 atom = 0; atom < since_.size(); ++atom) stay(out, core, atom, instant);
  append_event(out, 'i', 0, instant);
  out += R"(,"s":"g","cat":"end","name":")";
  out += name_of(end);
  out += R"(","args":{"steps":)";
  append_number(out, steps);
  if (end == End::Fault) append_json_fault(out, core);
  out += "}}\n]}\n";
}

}  // namespace bip::rt
