// See profile_text.hpp. The kind of a piece of code follows from the rows of the image that refer to it.
//
// Linear in the image's types and in the declarations of interactions.
#include "compiler/driver/profile_text.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "runtime/core/text.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

constexpr std::size_t kRowsShown = 20;

struct Line {
  double seconds = 0;
  std::uint64_t count = 0;  // steps or calls
  double part = -1;         // interactions: the part that is code; guards: how often true; else -1
  std::string type, what, place;
};

class Tables {
 public:
  Tables(const lower::LoweredSystem& lowered, const rt::Profile& profile)
      : lowered_(lowered), image_(lowered.image), profile_(profile) {
    describe();
    std::uint64_t steps = 0;
    for (const rt::InteractionProfile& row : profile.interactions()) {
      const double seconds = profile.seconds_of(row);
      BIP_ASSERT(seconds >= 0 && row.instances >= 1, "`{}` took {} s in {} instances", row.name, seconds,
                 row.instances);
      in_steps += seconds;
      steps += row.steps;
      const bool is_port = row.connector_type == rt::kNone;
      const rt::AtomType* atom = is_port ? &image_.atom_types[row.atom_type] : nullptr;
      std::string type = is_port ? fmt::format("port {} of {}", atom->ports[row.port].name, atom->name)
                                 : image_.connector_types[row.connector_type].name;
      if (row.instances > 1) type = fmt::format("{} x {}", row.instances, type);
      interactions.push_back({seconds, row.steps,
                              seconds > 0 ? std::min(profile.code_seconds_of(row) / seconds, 1.0) : 0, std::move(type),
                              row.name, place_of(row.loc)});
    }
    total = std::max(profile.seconds() - profile.measuring_seconds(), in_steps);
    add_code();
    for (std::vector<Line>* lines : {&interactions, &types, &code}) {
      std::stable_sort(lines->begin(), lines->end(),
                       [](const Line& a, const Line& b) { return a.seconds > b.seconds; });
    }
  }

  std::vector<Line> interactions, types, code;
  double total = 0, in_steps = 0;

 private:
  [[nodiscard]] std::string place_of(rt::SourceLine loc) const {
    std::string text;
    rt::append_line(text, image_, loc);
    return text;
  }

  void name_row(std::uint32_t row, std::string text) {
    BIP_ASSERT(row == rt::kNone || row < words_.size(), "code {} of {}", row, words_.size());
    if (row != rt::kNone) words_[row] = std::move(text);
  }
  void describe() {
    words_.resize(lowered_.units.size());
    for (const rt::AtomType& type : image_.atom_types) {
      name_row(type.initial_action, "initial");
      for (const rt::Transition& t : type.transitions) {
        std::string text = t.port == rt::kNone ? "internal" : fmt::format("on {}", type.ports[t.port].name);
        for (const auto& [word, places] : {std::pair(" from ", &t.from), {" to ", &t.to}}) {
          const char* between = word;
          for (const std::uint32_t place : *places) {
            text += between;
            text += type.places[place];
            between = ", ";
          }
        }
        name_row(t.guard, "guard: " + text);
        name_row(t.action, "action: " + text);
      }
      for (const rt::AtomPriority& rule : type.priorities)
        name_row(rule.guard, fmt::format("guard: priority {}", rule.name));
      for (const rt::Invariant& rule : type.invariants)
        name_row(rule.condition, fmt::format("invariant {}", rule.name));
    }
    for (const rt::ConnectorType& type : image_.connector_types) {
      for (const rt::Clause& clause : type.clauses) {
        std::string text = "on";
        for (const std::uint32_t param : clause.params) text += fmt::format(" {}", type.params[param].name);
        name_row(clause.guard, "guard: " + text);
        name_row(clause.up, "up: " + text);
        name_row(clause.down, "down: " + text);
      }
    }
    for (const rt::Priority& rule : image_.priorities)
      name_row(rule.guard, fmt::format("guard: priority {}", rule.name));
  }

  // A row for each unit, and one for each type that has any.
  void add_code() {
    struct Owner {
      lower::CodeOwner kind;
      std::uint32_t row;
    };
    std::vector<Owner> owners;
    for (std::size_t k = 0; k < lowered_.units.size(); ++k) {
      const lower::CodeUnit& unit = lowered_.units[k];
      const rt::CodeProfile& count = profile_.code(k);
      BIP_ASSERT(count.holds <= count.calls, "`{}` was true in {} of {} calls", unit.name, count.holds, count.calls);
      const bool is_rule = unit.owner == lower::CodeOwner::Priority;
      const char* type = unit.owner == lower::CodeOwner::Atom ? image_.atom_types[unit.owner_row].name
                         : is_rule                            ? "priorities"
                                                              : image_.connector_types[unit.owner_row].name;
      const double seconds = profile_.seconds_of(count);
      const bool is_guard = unit.kind == lower::CodeKind::Guard;
      const double part =
          is_guard && count.calls != 0 ? static_cast<double>(count.holds) / static_cast<double>(count.calls) : -1;
      const rt::SourceLine loc{unit.loc.file, unit.loc.line, unit.loc.column};
      code.push_back({seconds, count.calls, part, type, words_[k].empty() ? unit.name : words_[k], place_of(loc)});
      const std::uint32_t row = is_rule ? 0 : unit.owner_row;
      const auto same = std::find_if(owners.begin(), owners.end(),
                                     [&](const Owner& o) { return o.kind == unit.owner && o.row == row; });
      Line* line = nullptr;
      if (same == owners.end()) {
        owners.push_back({unit.owner, row});
        const bool is_atom = unit.owner == lower::CodeOwner::Atom;
        const rt::SourceLine at = is_atom   ? image_.atom_types[row].loc
                                  : is_rule ? rt::SourceLine{}
                                            : image_.connector_types[row].loc;
        types.push_back({0, 0, -1, is_atom ? "atom type" : is_rule ? "" : "connector type", type, place_of(at)});
        line = &types.back();
      } else {
        line = &types[static_cast<std::size_t>(same - owners.begin())];
      }
      line->seconds += seconds;
      line->count += count.calls;
    }
  }

  const lower::LoweredSystem& lowered_;
  const rt::Image& image_;
  const rt::Profile& profile_;
  std::vector<std::string> words_;  // by unit
};

std::string percent(double part) { return part < 0 ? "" : fmt::format("{:.1f}%", part * 100); }

void append_table(std::string& out, const std::vector<Line>& lines, const char* count, const char* part,
                  const char* what, double total, double rest) {
  out += fmt::format("{:>7} {:>11} {:>12} {:>10} {:>8}  {}\n", "share", "seconds", count, "ns each", part, what);
  const auto share = [&](double seconds) { return total > 0 ? percent(seconds / total) : ""; };
  std::size_t shown = 0;
  double left = 0;
  std::size_t hidden = 0;
  for (const Line& line : lines) {
    if (line.count == 0) continue;
    if (shown == kRowsShown) {
      left += line.seconds;
      ++hidden;
      continue;
    }
    ++shown;
    const double each = line.seconds * 1e9 / static_cast<double>(line.count);
    std::string name = line.type.empty() ? line.what : fmt::format("{}  {}", line.what, line.type);
    if (!line.place.empty()) name += "  " + line.place;
    out += fmt::format("{:>7} {:>11.6f} {:>12} {:>10.1f} {:>8}  {}\n", share(line.seconds), line.seconds, line.count,
                       each, percent(line.part), name);
  }
  if (hidden != 0)
    out += fmt::format("{:>7} {:>11.6f} {:>12} {:>10} {:>8}  {} more\n", share(left), left, "", "", "", hidden);
  if (rest >= 0)
    out += fmt::format("{:>7} {:>11.6f} {:>12} {:>10} {:>8}  between steps: choosing, writing, waiting\n", share(rest),
                       rest, "", "", "");
}

nlohmann::ordered_json rows_of(const std::vector<Line>& lines, const char* count, const char* part) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Line& line : lines) {
    nlohmann::ordered_json row{
        {"name", line.what}, {"type", line.type}, {"at", line.place}, {"seconds", line.seconds}, {count, line.count}};
    if (line.part >= 0) row[part] = line.part;
    rows.push_back(std::move(row));
  }
  return rows;
}

// Of robot modules: what their codels took (bip/codels.hpp); empty if there are none.
nlohmann::ordered_json codels_of(const lower::LoweredSystem& lowered) {
  if (lowered.library == nullptr) return nlohmann::ordered_json::array();
  const auto times = reinterpret_cast<const char* (*)()>(::dlsym(lowered.library, "bip_codel_times"));
  return times == nullptr ? nlohmann::ordered_json::array() : parse_json(times());
}
void append_codels(std::string& out, const nlohmann::ordered_json& codels) {
  if (codels.empty()) return;
  out += fmt::format("\n{:>12} {:>12} {:>12} {:>10}  codel\n", "calls", "ms", "longest ms", "over wcet");
  for (const auto& row : codels)
    out += fmt::format("{:>12} {:>12.3f} {:>12.3f} {:>10}  {}\n", row.value("calls", 0ULL),
                       static_cast<double>(row.value("ns", 0LL)) / 1e6,
                       static_cast<double>(row.value("longest_ns", 0LL)) / 1e6,
                       row.contains("over_wcet") ? std::to_string(row.value("over_wcet", 0ULL)) : "-",
                       row.value("codel", std::string()));
}

}  // namespace

std::string profile_text(const lower::LoweredSystem& lowered, const rt::Profile& profile, std::uint64_t steps) {
  const Tables tables(lowered, profile);
  std::string out = fmt::format("profile: {} step{}, {:.6f} s, and {:.6f} s for measuring, which is in no row\n", steps,
                                steps == 1 ? "" : "s", tables.total, profile.measuring_seconds());
  append_table(out, tables.interactions, "steps", "in code", "interaction", tables.total,
               tables.total - tables.in_steps);
  append_codels(out, codels_of(lowered));
  if (lowered.units.empty()) return out;
  append_table(out, tables.types, "calls", "", "code of", tables.total, -1);
  append_table(out, tables.code, "calls", "true", "code", tables.total, -1);
  return out;
}

std::string profile_json(const lower::LoweredSystem& lowered, const rt::Profile& profile, std::uint64_t steps) {
  const Tables tables(lowered, profile);
  nlohmann::ordered_json json{{"format", "bipc-profile"},
                              {"version", 1},
                              {"model", lowered.image.name},
                              {"steps", steps},
                              {"seconds", tables.total},
                              {"measuring", profile.measuring_seconds()},
                              {"between_steps", tables.total - tables.in_steps}};
  json["interactions"] = rows_of(tables.interactions, "steps", "in_code");
  json["types"] = rows_of(tables.types, "calls", "");
  json["code"] = rows_of(tables.code, "calls", "true");
  if (nlohmann::ordered_json codels = codels_of(lowered); !codels.empty()) json["codels"] = std::move(codels);
  return json_line(json) + '\n';
}

}  // namespace bip::driver
