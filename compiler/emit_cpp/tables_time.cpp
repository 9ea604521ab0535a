// Emits the tables of timed types; see image_tables.hpp.
#include "compiler/emit_cpp/table_text.hpp"
#include "compiler/emit_cpp/image_tables.hpp"

namespace bip::emit_cpp {

namespace {

constexpr const char* kOps[] = {"BoundOp::Lt", "BoundOp::Le", "BoundOp::Gt", "BoundOp::Ge", "BoundOp::Eq"};
constexpr const char* kUrgencies[] = {"Urgency::Lazy", "Urgency::Delayable", "Urgency::Eager"};
constexpr const char* kPolicies[] = {"EventPolicy::Remember", "EventPolicy::Ignore", "EventPolicy::Error"};

}  // namespace

std::string TableWriter::time_guard(const std::string& name, const rt::TimeGuard& when) {
  std::vector<std::string> rows;
  for (const rt::Bound& b : when.bounds) {
    rows.push_back(braces({row_text(b.clock), row_text(b.minus), kOps[static_cast<int>(b.op)], std::to_string(b.ticks),
                           row_text(b.variable)}));
  }
  return braces({table("Bound", name + "_bounds", rows), row_text(when.measure)});
}

std::string TableWriter::resume(const std::string& name, const rt::Resume& resume) {
  return braces({bool_text(resume.present), row_text(resume.guard), time_guard(name + "_resume", resume.when)});
}

std::string TableWriter::atom_time(const std::string& name, const rt::AtomTime* time) {
  if (time == nullptr) return {};
  std::vector<std::string> rows;
  for (const rt::Clock& c : time->clocks) {
    rows.push_back(braces(
        {string_literal(c.name), std::to_string(c.unit), row_text(c.variable), loc_text(c.loc), bool_text(c.is_read)}));
  }
  const std::string clocks = table("Clock", name + "_clocks", rows);
  rows.clear();
  for (const rt::TransitionTime& t : time->transitions) {
    rows.push_back(
        braces({time_guard(name, t.when), kUrgencies[static_cast<int>(t.urgency)], resume(name, t.resume),
                braces({bool_text(t.async.present), std::to_string(t.async.budget), row_text(t.async.overrun)})}));
  }
  const std::string transitions = table("TransitionTime", name + "_transition_times", rows);
  rows.clear();
  for (const rt::TimeGuard& i : time->invariants) rows.push_back(time_guard(name + "_invariant", i));
  const std::string invariants = table("TimeGuard", name + "_invariant_times", rows);
  const std::string initial = resume(name + "_initial", time->initial);
  rows.clear();
  for (const rt::EventPort& e : time->events) {
    rows.push_back(braces(
        {row_text(e.port), kPolicies[static_cast<int>(e.policy)], string_literal(e.event_class), row_text(e.source)}));
  }
  const std::string events = table("EventPort", name + "_events", rows);
  const std::string unique = names_.make(name + "_time");
  out_.line("constexpr AtomTime " + unique + " = " + braces({clocks, transitions, invariants, initial, events}) + ";");
  return "&" + unique;
}

}  // namespace bip::emit_cpp
