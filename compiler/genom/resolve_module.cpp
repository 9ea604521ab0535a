// See resolve_module.hpp. Linear searches: a module has tens of names.
#include "compiler/genom/resolve_module.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "compiler/genom/names.hpp"

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
    check_unique(module_.posters, module_.generation == 2 ? "poster" : "port", diags_);
    for (Service& s : module_.services) service(s);
    for (Poster& p : module_.posters) {
      if (p.task.is_set()) p.task_index = task(p.task);
    }
    for (SideLine& line : side_) apply(line);
    if (flavour_ == Flavour::Execution) free_answers();
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

  // Names of states that GenoM 2 codels yield; those of GenoM 3 are known already.
  void states_of(const Activity& activity, State& state) {
    if (module_.generation != 2) return;
    for (Yield& y : state.yields) {
      if (y.next == Next::State) y.state = find(activity.states, y.name.text);
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
      if (t.permanent.is_set() && is_about(line.subject, t.permanent.text)) {
        t.permanent_fails = has("ERROR");
        line.used = true;
      }
    }
    for (Service& s : module_.services) {
      if (s.validate.name.is_set() && is_about(line.subject, s.validate.name.text)) {
        s.validate_fails = has("ERROR");
        line.used = true;
      }
      if (!s.body.empty() && s.body.front().name.is_set() && is_about(line.subject, s.body.front().name.text)) {
        s.body_fails = has("ERROR");
        line.used = true;
      }
      for (State& state : s.activity.states) {
        if (!state.codel.name.is_set() || !is_about(line.subject, state.codel.name.text)) continue;
        line.used = true;
        if (flavour_ == Flavour::Verification) narrow(state, line);
      }
    }
  }

  // Beside its task run codels of activities: of others somebody waits for the answer.
  void codel_async(SideLine& line) {
    std::int64_t budget = 0;
    if (!line.words.empty() && !read_time(line.words, budget)) {
      line.used = true;
      diags_.report(Diag::kB6022, line.words[0].range, fmt::format("`{}` is no length of time", line.words[0].text))
          .help("a number with `us`, `ms` or `s`: `20 ms`");
      return;
    }
    for (Service& s : module_.services) {
      for (State& state : s.activity.states) {
        if (!state.codel.name.is_set() || !is_about(line.subject, state.codel.name.text)) continue;
        state.codel.is_async = true;
        state.codel.budget_us = budget;
        line.used = true;
      }
      const bool is_control = std::any_of(s.body.begin(), s.body.end(),
                                          [&](const Codel& c) { return is_about(line.subject, c.name.text); });
      if (is_control || is_about(line.subject, s.validate.name.text)) waited_for(line);
    }
    for (const Task& t : module_.tasks) {
      if (is_about(line.subject, t.permanent.text)) waited_for(line);
    }
  }

  // Its task waits for it.
  void codel_takes(SideLine& line) {
    std::int64_t budget = 0;
    if (!read_time(line.words, budget)) {
      line.used = true;
      diags_
          .report(Diag::kB6022, line.words.empty() ? line.subject.range : line.words[0].range,
                  line.words.empty() ? "`takes` without a length of time"
                                     : fmt::format("`{}` is no length of time", line.words[0].text))
          .help("a number with `us`, `ms` or `s`: `20 ms`");
      return;
    }
    for (Service& s : module_.services) {
      for (State& state : s.activity.states) {
        if (!state.codel.name.is_set() || !is_about(line.subject, state.codel.name.text)) continue;
        state.codel.budget_us = budget;
        line.used = true;
      }
    }
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

  // Only what the state permits, in its order; OTHER comes on top.
  void narrow(State& state, const SideLine& line) {
    std::vector<Yield> kept;
    for (const Yield& y : state.yields) {
      const std::string_view word = y.next == Next::Ether    ? (module_.generation == 2 ? "ETHER" : "ether")
                                    : y.next == Next::Zombie ? "ZOMBIE"
                                    : y.next == Next::Sleep  ? "SLEEP"
                                                             : std::string_view(y.name.text);
      if (std::any_of(line.words.begin(), line.words.end(), [&](const Name& w) { return w.text == word; }))
        kept.push_back(y);
    }
    for (const Name& w : line.words) {
      if (w.text == "OTHER") {
        kept.push_back({Next::Other, w, 0});
      } else if (std::none_of(state.yields.begin(), state.yields.end(), [&](const Yield& y) {
                   return y.name.text == w.text ||
                          (y.next == Next::Ether && (w.text == "ETHER" || w.text == "ether")) ||
                          (y.next == Next::Zombie && w.text == "ZOMBIE") ||
                          (y.next == Next::Sleep && w.text == "SLEEP");
                 })) {
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
