// See resolve_module.hpp. Linear searches: a module has tens of names.
#include "compiler/genom/resolve_module.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include "compiler/genom/names.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

template <class Row>
std::vector<std::string> names_of(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& r : rows) names.push_back(r.name.text);
  return names;
}

template <class Row>
std::size_t find(const std::vector<Row>& rows, const std::string& name) {
  const auto it = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name.text == name; });
  return static_cast<std::size_t>(it - rows.begin());
}

template <class Row>
void check_unique(const std::vector<Row>& rows, const char* kind, Diagnostics& diags) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t first = find(rows, rows[i].name.text);
    if (first < i)
      diags.report(Diag::kB6013, rows[i].name.range, kind, rows[i].name.text)
          .label(rows[first].name.range, "the first one");
  }
}

class Resolver {
 public:
  Resolver(Module& module, std::vector<SideLine>& side, Flavour flavour, Diagnostics& diags)
      : module_(module), side_(side), flavour_(flavour), diags_(diags) {}

  void run(std::size_t instances) {
    check_unique(module_.services, module_.generation == 2 ? "request" : "service", diags_);
    check_unique(module_.tasks, "task", diags_);
    // Ports have been checked as they were read.
    if (module_.generation == 2) check_unique(module_.posters, "poster", diags_);
    for (Service& s : module_.services) service(s);
    for (Poster& p : module_.posters) {
      if (p.task.is_set()) p.task_index = task(p.task);
    }
    for (SideLine& line : side_) apply(line);
    if (flavour_ == Flavour::Execution) {
      free_answers();
      check_answer_codes();
    }
    for (Service& s : module_.services) {
      for (State& state : s.activity.states) states_of(s.activity, state);
      const std::size_t own = find(module_.services, s.name.text);
      const bool interrupts_itself = std::find(s.interrupted.begin(), s.interrupted.end(), own) != s.interrupted.end();
      s.instances = s.kind == ServiceKind::Control ? 1
                    : interrupts_itself            ? std::max<std::size_t>(instances, 2)
                                                   : instances;
    }
  }

 private:
  std::size_t task(const Name& name) {
    const std::size_t found = find(module_.tasks, name.text);
    if (found < module_.tasks.size()) return found;
    auto d = diags_.report(Diag::kB6008, name.range, module_.generation == 2 ? "execution task" : "task", name.text);
    for (const std::string& similar : similar_names(name.text, names_of(module_.tasks)))
      d.help(fmt::format("there is `{}`", similar), name.range, similar);
    return 0;
  }

  void service(Service& s) {
    // A report that is listed twice is one; so are two that BIP cannot tell apart.
    std::vector<Name> reports;
    for (Name& r : s.reports) {
      if (std::none_of(reports.begin(), reports.end(),
                       [&](const Name& known) { return bip_name(known.text) == bip_name(r.text); }))
        reports.push_back(std::move(r));
    }
    s.reports = std::move(reports);
    if (s.kind == ServiceKind::Execution && s.task.is_set()) s.task_index = task(s.task);
    if (s.interrupts_all) {
      const std::size_t own = find(module_.services, s.name.text);
      for (std::size_t i = 0; i < module_.services.size(); ++i) {
        // `init` is over before it can be asked for again.
        if (module_.services[i].kind == ServiceKind::Execution && !(i == own && s.is_init)) s.interrupted.push_back(i);
      }
    }
    for (const Name& name : s.interrupts) {
      const std::size_t found = find(module_.services, name.text);
      if (found == module_.services.size()) {
        // genom3 refuses such a description.
        auto d = module_.generation == 3 ? diags_.report(Diag::kB6008, name.range, "service", name.text)
                                         : diags_.report(Diag::kB6006, name.range, name.text);
        for (const std::string& similar : similar_names(name.text, names_of(module_.services)))
          d.help(fmt::format("there is `{}`", similar), name.range, similar);
      } else if (module_.services[found].kind == ServiceKind::Execution &&
                 std::find(s.interrupted.begin(), s.interrupted.end(), found) == s.interrupted.end()) {
        s.interrupted.push_back(found);
      }
    }
    std::sort(s.interrupted.begin(), s.interrupted.end());
    BIP_ASSERT(std::adjacent_find(s.interrupted.begin(), s.interrupted.end()) == s.interrupted.end(),
               "`{}` interrupts a service twice", s.name.text);
    others(s, s.before, s.before_index, s.is_before_itself);
    others(s, s.after, s.after_index, s.is_after_itself);
  }

  void others(const Service& s, const std::vector<Name>& names, std::vector<std::size_t>& into, bool& itself) {
    for (const Name& name : names) {
      const std::size_t found = find(module_.services, name.text);
      if (name.text == s.name.text) {
        // `before` itself: once.
        itself = true;
        if (&names == &s.after) diags_.report(Diag::kB6023, name.range, name.text);
        continue;
      }
      if (found < module_.services.size()) {
        into.push_back(found);
        continue;
      }
      auto d = diags_.report(Diag::kB6008, name.range, "service", name.text);
      for (const std::string& similar : similar_names(name.text, names_of(module_.services)))
        d.help(fmt::format("there is `{}`", similar), name.range, similar);
    }
  }

  // A C++ function returns what it likes.
  void free_answers() {
    for (Service& s : module_.services) {
      s.validate_fails = s.body_fails = true;
      for (State& state : s.activity.states) {
        if (state.codel.name.is_set()) state.yields.push_back({Next::Other, {}, 0});
      }
    }
    for (Task& t : module_.tasks) {
      t.permanent_fails = true;
      for (State& state : t.activity.states) state.yields.push_back({Next::Other, {}, 0});
    }
  }

  // Codels of C++ answer with numbers: beyond so many states, two answers would have the same one.
  void check_answer_codes() {
    const auto check = [&](const Activity& activity, const char* kind, const Name& owner) {
      if (activity.states.size() > kMaxCalledStates)
        diags_.report(Diag::kB6010, owner.range, fmt::format("the number of states of {} `{}`", kind, owner.text),
                      activity.states.size(), 1, kMaxCalledStates);
    };
    for (const Service& s : module_.services) check(s.activity, "service", s.name);
    for (const Task& t : module_.tasks) check(t.activity, "task", t.name);
  }

  // Names of states that GenoM 2 codels yield; those of GenoM 3 are known already.
  void states_of(const Activity& activity, State& state) {
    if (module_.generation != 2) return;
    for (Yield& y : state.yields) {
      if (y.next == Next::State) y.state = find(activity.states, y.name.text);
      BIP_ASSERT(y.next != Next::State || y.state < activity.states.size() || diags_.has_errors(),
                 "`{}` is no state of the activity", y.name.text);
    }
  }

  // "Goto", or "demo.Goto".
  [[nodiscard]] bool is_about(const Name& subject, const std::string& name) const {
    return subject.text == name || subject.text == module_.name.text + "." + name;
  }

  void apply(SideLine& line) {
    if (line.kind == "codel") {
      codel_yields(line);
    } else if (line.kind == "async") {
      codel_async(line);
    } else if (line.kind == "takes") {
      codel_takes(line);
    } else if (line.kind == "trigger") {
      for (Service& s : module_.services) {
        if (!is_about(line.subject, s.name.text)) continue;
        s.waits = true;
        line.used = true;
      }
    } else if (line.kind == "request") {
      for (Service& s : module_.services) {
        if (!is_about(line.subject, s.name.text)) continue;
        s.overtakes = true;
        line.used = true;
      }
    } else {
      for (Task& t : module_.tasks) {
        if (!is_about(line.subject, t.name.text)) continue;
        t.reads.insert(t.reads.end(), line.words.begin(), line.words.end());
        t.freshness.resize(t.reads.size(), line.within);
        line.used = true;
      }
    }
  }

  void codel_yields(SideLine& line) {
    const auto has = [&](std::string_view word) {
      return std::any_of(line.words.begin(), line.words.end(), [&](const Name& w) { return w.text == word; });
    };
    for (Task& t : module_.tasks) {
      if (t.permanent.name.is_set() && is_about(line.subject, t.permanent.name.text)) {
        t.permanent_fails = has("ERROR");
        line.used = true;
      }
    }
    for (Service& s : module_.services) {
      if (s.validate.name.is_set() && is_about(line.subject, s.validate.name.text)) {
        s.validate_fails = has("ERROR");
        line.used = true;
      }
      for (const Codel& c : s.body) {
        if (!c.name.is_set() || !is_about(line.subject, c.name.text)) continue;
        s.body_fails = has("ERROR");
        line.used = true;
      }
      for (State& state : s.activity.states) narrow_if_about(line, state);
    }
    for (Task& t : module_.tasks) {
      for (State& state : t.activity.states) narrow_if_about(line, state);
    }
  }

  void narrow_if_about(SideLine& line, State& state) {
    if (!state.codel.name.is_set() || !is_about(line.subject, state.codel.name.text)) return;
    line.used = true;
    if (flavour_ == Flavour::Verification) narrow(state, line);
  }

  // Codels of activities and of GenoM 3's tasks run beside their task. A caller waits for the answer of all others.
  void codel_async(SideLine& line) {
    std::int64_t budget = 0;
    if (!line.words.empty() && !read_budget(line, budget)) return;
    for_each_codel([&](Codel& codel, CodelRole role) {
      if (!is_about(line.subject, codel.name.text) || !is_only_budget(line, codel, budget)) return;
      if (role != CodelRole::State) return waited_for(line);
      codel.is_async = true;
      if (budget > 0) codel.budget_us = budget;
    });
  }

  // A caller waits for the answer.
  void codel_takes(SideLine& line) {
    std::int64_t budget = 0;
    if (!read_budget(line, budget)) return;
    for_each_codel([&](Codel& codel, CodelRole) {
      if (!is_about(line.subject, codel.name.text) || !is_only_budget(line, codel, budget)) return;
      if (codel.is_async) {
        diags_
            .report(
                Diag::kB6022, line.subject.range,
                fmt::format("codel `{}` is async in the description: its task does not wait for it", codel.name.text))
            .label(codel.name.range, "`async` here")
            .help(fmt::format("`codel {} async TIME` gives it a budget", line.subject.text));
        return;
      }
      codel.budget_us = budget;
    });
  }

  // How a codel is run: as a state of an activity, or at once for somebody who waits for its answer.
  enum class CodelRole : std::uint8_t { State, AtOnce };

  // All codels of the module that have a name.
  template <class Visit>
  void for_each_codel(Visit visit) {
    const auto visit_named = [&](Codel& codel, CodelRole role) {
      if (codel.name.is_set()) visit(codel, role);
    };
    for (Service& s : module_.services) {
      visit_named(s.validate, CodelRole::AtOnce);
      for (Codel& c : s.body) visit_named(c, CodelRole::AtOnce);
      for (State& state : s.activity.states) visit_named(state.codel, CodelRole::State);
    }
    for (Task& t : module_.tasks) {
      visit_named(t.permanent, CodelRole::AtOnce);
      for (State& state : t.activity.states) visit_named(state.codel, CodelRole::State);
    }
  }

  // The first line about the time of a codel, and no `wcet` of the description beside it. Marks the line as used. A
  // codel may stand in several places; what is wrong with it is told once.
  bool is_only_budget(SideLine& line, const Codel& codel, std::int64_t budget) {
    const bool is_first_place = !line.used;
    line.used = true;
    const auto [known, is_new] = timed_.try_emplace(codel.name.text, &line, codel.budget_us);
    const auto& [first, described] = known->second;
    if (first != &line) {
      if (is_first_place)
        diags_
            .report(Diag::kB6022, line.subject.range,
                    first->kind == line.kind
                        ? fmt::format("second `{}` of codel `{}`", line.kind, codel.name.text)
                        : fmt::format("codel `{}` cannot be `async` and have its task wait for it (`takes`)",
                                      codel.name.text))
            .label(first->subject.range, "the first one");
      return false;
    }
    if (budget > 0 && described > 0) {
      if (is_first_place)
        diags_
            .report(Diag::kB6022, line.subject.range,
                    fmt::format("codel `{}` has a budget in the description", codel.name.text))
            .label(codel.name.range, "`wcet` here");
      return false;
    }
    return true;
  }

  // The time of a line; what is none is reported.
  bool read_budget(SideLine& line, std::int64_t& budget) {
    if (read_time(line.words, budget)) return true;
    line.used = true;
    std::string text;
    for (const Name& w : line.words) text += (text.empty() ? "" : " ") + w.text;
    SourceRange range = line.subject.range;
    if (!line.words.empty()) range = {range.file, line.words.front().range.begin, line.words.back().range.end};
    diags_
        .report(Diag::kB6022, range,
                text.empty() ? fmt::format("`{}` without a length of time", line.kind)
                             : fmt::format("`{}` is no length of time", text))
        .help("a whole number with `us`, `ms` or `s`: `20 ms`");
    return false;
  }

  void waited_for(SideLine& line) {
    diags_.report(Diag::kB6024, line.subject.range, line.subject.text,
                  "which only codels of activities and GenoM 3's tasks can be");
    line.used = true;
  }

  // "20ms", or "20", "ms".
  static bool read_time(const std::vector<Name>& words, std::int64_t& us) {
    std::string text;
    for (const Name& w : words) text += w.text;
    std::size_t digits = 0;
    while (digits < text.size() && text[digits] >= '0' && text[digits] <= '9' && us < 1'000'000'000)
      us = us * 10 + (text[digits++] - '0');
    const std::string unit = text.substr(digits);
    if (digits == 0 || us == 0 || (unit != "us" && unit != "ms" && unit != "s")) return false;
    us *= unit == "s" ? 1'000'000 : unit == "ms" ? 1000 : 1;
    return us <= 1'000'000'000'000;
  }

  // Is `word` how a side file writes this answer?
  [[nodiscard]] bool is_written(const Yield& y, std::string_view word) const {
    switch (y.next) {
      case Next::Ether: return word == (module_.generation == 2 ? "ETHER" : "ether");
      case Next::Zombie: return word == "ZOMBIE";
      case Next::Sleep: return word == "SLEEP";
      case Next::Pause: return word == y.name.text || word == "pause::" + y.name.text;
      case Next::State: return word == y.name.text;
      case Next::Other: return false;
    }
    return false;
  }

  // Only what the state permits, in its order; OTHER comes on top.
  void narrow(State& state, const SideLine& line) {
    std::vector<Yield> kept;
    for (const Yield& y : state.yields) {
      if (std::any_of(line.words.begin(), line.words.end(), [&](const Name& w) { return is_written(y, w.text); }))
        kept.push_back(y);
    }
    for (const Name& w : line.words) {
      if (w.text == "OTHER") {
        kept.push_back({Next::Other, w, 0});
      } else if (std::none_of(state.yields.begin(), state.yields.end(),
                              [&](const Yield& y) { return is_written(y, w.text); })) {
        diags_.report(
            Diag::kB6022, w.range,
            fmt::format("codel `{}` of state `{}` cannot yield `{}`", state.codel.name.text, state.name.text, w.text));
      }
    }
    if (!kept.empty()) state.yields = std::move(kept);
  }

  Module& module_;
  std::vector<SideLine>& side_;
  Flavour flavour_;
  Diagnostics& diags_;
  // By codel: the first line about its time, and the budget that the description gives it.
  std::map<std::string, std::pair<const SideLine*, std::int64_t>> timed_;
};

}  // namespace

void resolve(Module& module, std::vector<SideLine>& side, std::size_t instances, Flavour flavour, Diagnostics& diags) {
  Resolver(module, side, flavour, diags).run(instances);
}

std::vector<SideLine> parse_side_file(const SourceMap& sources, FileId file, Diagnostics& diags) {
  std::vector<SideLine> lines;
  const std::string_view text = sources.text(file);
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t stop = std::min(text.find('#', begin), end);
    std::vector<Name> words;
    for (std::size_t at = begin; at < stop;) {
      const auto is_blank = [&](std::size_t i) { return text[i] == ' ' || text[i] == '\t' || text[i] == '\r'; };
      while (at < stop && is_blank(at)) ++at;
      std::size_t last = at;
      while (last < stop && !is_blank(last)) ++last;
      if (last > at)
        words.push_back({std::string(text.substr(at, last - at)),
                         {file, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(last)}});
      at = last;
    }
    begin = end + 1;
    if (words.empty()) continue;
    const std::string& kind = words[0].text;
    if (kind == "codel" && words.size() >= 3 && (words[2].text == "async" || words[2].text == "takes")) {
      lines.push_back({words[2].text, words[1], {words.begin() + 3, words.end()}, false});
      continue;
    }
    const std::string verb = kind == "codel"     ? "yields"
                             : kind == "trigger" ? "waits"
                             : kind == "request" ? "overtakes"
                             : kind == "task"    ? "reads"
                                                 : "";
    const bool is_whole = verb == "waits" || verb == "overtakes";
    if (verb.empty() || words.size() < 3 || words[2].text != verb || is_whole != (words.size() == 3)) {
      diags.report(Diag::kB6022, words[0].range, "this is no line of a side file")
          .help(
              "`codel NAME yields A B`, `codel NAME async 20 ms`, `codel NAME takes 20 ms`, `trigger SERVICE waits`, "
              "`request SERVICE overtakes` or `task TASK reads MODULE.POSTER [within AGE]`");
      continue;
    }
    // `within N` after posters.
    std::int64_t within = 0;
    if (kind == "task" && words.size() > 5 && words[words.size() - 2].text == "within") {
      const std::string& number = words.back().text;
      const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), within);
      if (error != std::errc() || rest != number.data() + number.size() || within < 1 || within > 1'000'000) {
        diags.report(Diag::kB6022, words.back().range, fmt::format("`{}` is no age of a poster", number))
            .help("a number of steps of `PosterAge`, from 1 to 1000000");
        continue;
      }
      words.resize(words.size() - 2);
    }
    lines.push_back({kind, words[1], {words.begin() + 3, words.end()}, false, within});
  }
  return lines;
}

void report_unused(const std::vector<SideLine>& side, Diagnostics& diags) {
  for (const SideLine& line : side) {
    if (!line.used)
      diags.report(Diag::kB6022, line.subject.range,
                   fmt::format("there is no {} `{}` in what is translated",
                               line.kind == "trigger" || line.kind == "request" ? "service"
                               : line.kind == "async" || line.kind == "takes"   ? "codel"
                                                                                : line.kind,
                               line.subject.text));
  }
}

}  // namespace bip::genom
