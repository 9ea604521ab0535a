// The automaton of each atom type as DOT: circles are places, arrows are transitions. A transition of a Petri net,
// which has several places on one side, is a bar.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "compiler/graph/code_text.hpp"
#include "compiler/graph/dot.hpp"
#include "compiler/system/system.hpp"

namespace bip::graph {
namespace {

class Automaton {
 public:
  Automaton(std::string& out, const System& system, std::size_t row)
      : out_(out),
        code_(system.code),
        type_(system.atom_types[AtomTypeId(row)]),
        names_(names_of(type_)),
        id_(fmt::format("t{}", row)) {}

  void run() {
    put("  subgraph cluster_{} {{\n    label={};\n", id_, dot_string(heading()));
    for (std::size_t p = 0; p < type_.places.size(); ++p)
      put("    {}_p{} [shape={}, label={}];\n", id_, p, is_final(p) ? "doublecircle" : "circle",
          dot_string(type_.places[p]));
    put("    {}_i [shape=point];\n", id_);
    const std::string action =
        lines_of({shortened(text_of(code_, type_.initial_action, names_)), resume(type_.initial_resume)});
    for (std::size_t k = 0; k < type_.initial.size(); ++k)
      edge(id_ + "_i", place(type_.initial[k]), k == 0 ? action : "");
    for (std::size_t t = 0; t < type_.transitions.size(); ++t) transition(t);
    out_ += "  }\n";
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), text, std::forward<Args>(args)...);
  }

  [[nodiscard]] bool is_final(std::size_t row) const {
    return std::binary_search(type_.final_places.begin(), type_.final_places.end(), row);
  }
  [[nodiscard]] std::string place(std::uint32_t row) const { return fmt::format("{}_p{}", id_, row); }

  void edge(const std::string& from, const std::string& to, const std::string& label, const char* more = "") {
    put("    {} -> {} [label={}{}];\n", from, to, dot_string(label), more);
  }

  [[nodiscard]] std::string resume(const Resume& r) const { return shortened(resume_text(code_, type_, r)); }

  [[nodiscard]] std::string heading() const {
    const AtomTypeHeading heading = heading_of(code_, type_);
    std::vector<std::string> lines{shortened(heading.name)};
    for (const std::string& line : heading.lines) lines.push_back(shortened(line));
    return lines_of(lines);
  }

  void transition(std::size_t t) {
    const Transition& row = type_.transitions[t];
    const bool is_internal = row.port == Transition::kInternal;
    const char* urgency = row.urgency == Urgency::Lazy ? "" : name_of(row.urgency);
    const std::string label =
        lines_of({is_internal ? "internal" : type_.ports[row.port].name,
                  shortened(in_brackets(condition_of(code_, type_, row.guard, row.when))), urgency,
                  shortened(text_of(code_, row.action, names_)), row.async.present ? "async" : "", resume(row.resume)});
    const char* style = is_internal ? ", style=dashed" : "";
    if (row.from.size() == 1 && row.to.size() == 1) {
      edge(place(row.from[0]), place(row.to[0]), label, style);
      return;
    }
    put("    {}_b{} [shape=box, width=0.1, label={}];\n", id_, t, dot_string(label));
    for (const std::uint32_t from : row.from)
      put("    {} -> {}_b{}{};\n", place(from), id_, t, is_internal ? " [style=dashed]" : "");
    for (const std::uint32_t to : row.to)
      put("    {}_b{} -> {}{};\n", id_, t, place(to), is_internal ? " [style=dashed]" : "");
  }

  std::string& out_;
  const CodeTable& code_;
  const AtomType& type_;
  CodeNames names_;
  std::string id_;
};

}  // namespace

void put_automata(std::string& out, const System& system) {
  for (std::size_t row = 0; row < system.atom_types.size(); ++row) Automaton(out, system, row).run();
}

}  // namespace bip::graph
