// See console.hpp.
#include "compiler/debug/console.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/debug/back_refusal.hpp"
#include "compiler/debug/event_values.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/core/why_not.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/trace/future.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::debug {

namespace {

constexpr std::uint64_t kMostCandidates = 100, kMostAtoms = 100, kMostStepLines = 1000;

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

bool read_number(std::string_view text, std::uint64_t& number) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() && read.ptr == text.data() + text.size();
}

}  // namespace

struct Console::Command {
  char letter;
  const char* arguments;
  const char* help;
  void (Console::*execute)(std::string_view rest);
};

const std::vector<Console::Command>& Console::commands() {
  static const std::vector<Command> kCommands = {
      {'s', "[N]", "take N steps (1): recorded ones after going back, else steps that the policy chooses",
       &Console::step},
      {'b', "[N]", "go back N moves (1)", &Console::back},
      {'l', "", "list the candidates; `*` marks the recorded one", &Console::list},
      {'c', "K", "take candidate K; the recorded moves ahead are dropped if it is another one", &Console::choose},
      {'r', "[TARGET]", "run to TARGET, to a breakpoint or to the end", &Console::run},
      {'R', "[TARGET]", "run back to the last TARGET or breakpoint, or to the initial state", &Console::run_back},
      {'g', "N", "go to the state after N recorded moves", &Console::go_to},
      {'i', "", "go back to the initial state", &Console::restart},
      {'w', "[N]", "walk N steps (1) that the policy chooses; the recorded moves ahead are dropped", &Console::walk},
      {'u', "", "undo the last command that moved or dropped moves", &Console::undo},
      {'p', "[PATH]", "print places, data and clocks of the components whose paths begin with PATH",
       &Console::print_atoms},
      {'d', "", "print the differences that the last move made", &Console::print_changes},
      {'y', "[NAME]", "explain why a connector or port is not possible; without NAME, a deadlock", &Console::why},
      {'e', "EXPR", "evaluate an expression", &Console::evaluate},
      {'x', "[EXPR]", "display an expression after each movement; without EXPR, display none", &Console::display},
      {'m', "[TARGET]", "mark TARGET with a breakpoint; without TARGET, list the breakpoints",
       &Console::set_breakpoint},
      {'M', "N", "remove breakpoint N", &Console::delete_breakpoint},
      {'t', "TIME", "let time pass to the instant TIME, or by +TIME", &Console::pass_time},
      {'v', "PORT [V..]", "deliver an event with these values to an external port", &Console::post_event},
      {'a', "DATA V", "assign a value to a variable", &Console::assign},
      {'o', "FILE", "write the steps from the initial state to here as a trace (JSON lines)", &Console::save},
      {'h', "", "print this help", &Console::help},
      {'q', "", "quit", nullptr},
  };
  return kCommands;
}

Console::Console(rt::DebugSession& session, const DebugModel& model, std::uint64_t seed, ConsoleOutput output)
    : session_(session), model_(model), seed_(seed), output_(std::move(output)) {
  session_.on_log = [this](const rt::Breakpoint& b) { output_.print(b.message + "\n"); };
}

void Console::refuse(const std::string& problem, const std::string& help) { output_.refuse(problem, help); }

std::string Console::prompt() const { return fmt::format("bipc step #{}> ", session_.position()); }

std::vector<std::string> Console::complete(const std::string& word) const {
  constexpr std::size_t kMostOffered = 200;
  return model_.complete(word, kMostOffered);
}

Console::Next Console::execute(std::string_view line) {
  line = without_blanks(line);
  if (line.empty()) return Next::GoOn;
  const char letter = line.front();
  const std::string_view rest = without_blanks(line.substr(1));
  const bool is_one_letter = line.size() == 1 || line[1] == ' ' || line[1] == '\t';
  for (const Command& command : commands()) {
    if (!is_one_letter || command.letter != letter) continue;
    if (command.execute == nullptr) return Next::Quit;
    (this->*command.execute)(rest);
    return Next::GoOn;
  }
  refuse(fmt::format("no command `{}`", line.substr(0, line.find(' '))), "`h` lists the commands");
  return Next::GoOn;
}

bool Console::read_count(std::string_view rest, std::uint64_t without, std::uint64_t& count) {
  count = without;
  if (rest.empty() || read_number(rest, count)) return true;
  refuse(fmt::format("`{}` is not a whole number", rest));
  return false;
}

// -- What is printed after a movement --

void Console::print_last_move() {
  const rt::LastMove* const last = session_.last_move();
  if (last != nullptr) output_.print(last->text + "\n");
}

void Console::print_where() {
  std::string text = fmt::format("at {}", session_.position());
  if (session_.length() > session_.position()) text += fmt::format(" of {}", session_.length());
  if (session_.core().is_timed()) {
    text += ", instant ";
    rt::append_time(text, session_.core().now());
  }
  if (!session_.is_at_fault()) text += ", " + rt::counted(session_.core().candidate_count(), "candidate");
  output_.print(text + "\n");
}

void Console::print_displays() {
  for (const WatchRow& row : displays_) {
    const Result<std::string> value = model_.evaluate(row.text, session_.core());
    output_.print(fmt::format("  {} = {}\n", row.text, value ? *value : value.error()));
  }
}

void Console::tell(rt::Halt halt, Lines lines) {
  if (halt == rt::Halt::Refused) {
    session_.drop_mark();
    const bool is_cpp = session_.problem() == session_.back_refusal() && !session_.problem().empty();
    refuse(is_cpp ? back_refused(session_.problem()) : session_.problem(), is_cpp ? kGoesBackHelp : "");
    return;
  }
  if (lines == Lines::Last) print_last_move();
  switch (halt) {
    case rt::Halt::Breakpoint:
      for (const rt::u32 row : session_.reached()) {
        BIP_ASSERT(row < session_.breakpoints().size(), "breakpoint {} of {}", row, session_.breakpoints().size());
        const rt::Breakpoint& b = session_.breakpoints()[row];
        output_.print(b.is_temporary ? fmt::format("reached {}\n", b.text)
                                     : fmt::format("breakpoint {}: {}\n", b.number, b.text));
      }
      break;
    case rt::Halt::Deadlock: output_.print(rt::end_story(session_.core(), session_.position(), seed_)); break;
    case rt::Halt::Fault: output_.print(session_.fault()); break;
    case rt::Halt::Begin: output_.print("this is the initial state\n"); break;
    case rt::Halt::Interrupted: output_.print("interrupted\n"); break;
    case rt::Halt::Limit:
      output_.print(fmt::format("stopped after {} moves; `r` goes on\n", rt::DebugSession::kMostMovesOfRun));
      break;
    case rt::Halt::Done:
    case rt::Halt::Refused: break;
  }
  print_where();
  print_displays();
}

void Console::print_state() { tell(session_.is_at_fault() ? rt::Halt::Fault : rt::Halt::Done, Lines::Last); }

// -- Movement --

void Console::take_steps(std::uint64_t count) {
  session_.track(count <= kMostStepLines ? rt::Tracking::Every : rt::Tracking::OnRequest);
  rt::Halt halt = rt::Halt::Done;
  for (std::uint64_t k = 0; k < count && halt == rt::Halt::Done; ++k) {
    const std::uint64_t before = session_.position();
    halt = session_.step();
    if (session_.position() != before && count <= kMostStepLines) print_last_move();
  }
  session_.track(rt::Tracking::OnRequest);
  tell(halt, Lines::None);
}

void Console::step(std::string_view rest) {
  std::uint64_t count = 0;
  if (!read_count(rest, 1, count)) return;
  session_.mark();
  take_steps(count);
}

void Console::walk(std::string_view rest) {
  std::uint64_t count = 0;
  if (!read_count(rest, 1, count)) return;
  session_.mark();
  session_.branch();
  take_steps(count);
}

void Console::back(std::string_view rest) {
  std::uint64_t count = 0;
  if (!read_count(rest, 1, count)) return;
  session_.mark();
  tell(session_.back(count), Lines::None);
}

void Console::choose(std::string_view rest) {
  std::uint64_t k = 0;
  if (rest.empty() || !read_number(rest, k)) return refuse("`c` needs the number of a candidate", "`l` lists them");
  session_.mark();
  session_.track(rt::Tracking::Every);
  const rt::Halt halt = session_.choose(k);
  session_.track(rt::Tracking::OnRequest);
  tell(halt, Lines::Last);
}

void Console::add_temporary(rt::Breakpoint breakpoint) {
  BIP_ASSERT(std::none_of(session_.breakpoints().begin(), session_.breakpoints().end(),
                          [](const rt::Breakpoint& b) { return b.is_temporary; }),
             "a temporary breakpoint was left, of {}", session_.breakpoints().size());
  breakpoint.is_temporary = true;
  session_.breakpoints().push_back(std::move(breakpoint));
}

void Console::remove_temporary() {
  std::erase_if(session_.breakpoints(), [](const rt::Breakpoint& b) { return b.is_temporary; });
}

// False: the target is none, and that was said.
bool Console::add_target(std::string_view rest) {
  if (rest.empty()) return true;
  Result<rt::Breakpoint> target = model_.parse_breakpoint(std::string(rest));
  if (target) add_temporary(std::move(*target));
  else refuse(fmt::format("`{}`: {}", rest, target.error()));
  return static_cast<bool>(target);
}

void Console::run(std::string_view rest) {
  if (!add_target(rest)) return;
  session_.mark();
  tell(session_.run(), Lines::Last);
  remove_temporary();
}

void Console::run_back(std::string_view rest) {
  if (!add_target(rest)) return;
  session_.mark();
  tell(session_.run_back(), Lines::Last);
  remove_temporary();
}

void Console::go_to(std::string_view rest) {
  std::uint64_t position = 0;
  if (rest.empty() || !read_number(rest, position)) return refuse("`g` needs a number of moves");
  session_.mark();
  tell(session_.go_to(position), Lines::Last);
}

void Console::restart(std::string_view) {
  session_.mark();
  tell(session_.go_to(0), Lines::None);
}

void Console::undo(std::string_view) {
  if (!session_.undo()) return refuse("there is nothing to undo");
  print_where();
  print_displays();
}

void Console::pass_time(std::string_view rest) {
  const bool is_span = rest.starts_with('+');
  const rt::i64 time = rt::parse_time(rest.substr(is_span ? 1 : 0));
  if (time < 0) return refuse("`t` needs an instant, `1s500ms`, or a span, `+20us`, of at most 4611686018s");
  const rt::i64 from = is_span ? session_.core().now() : 0;
  if (time > rt::kMaxTicks - from) {
    std::string last;
    rt::append_time(last, rt::kMaxTicks);
    return refuse(fmt::format("no instant is later than {}", last));
  }
  session_.mark();
  tell(session_.delay(from + time), Lines::None);
}

void Console::post_event(std::string_view rest) {
  const std::size_t end = std::min(rest.find(' '), rest.size());
  const std::string port(rest.substr(0, end));
  if (port.empty()) return refuse("`v` needs an external port");
  session_.mark();
  tell(session_.post(port, event_values(rest.substr(end))), Lines::Last);
}

void Console::assign(std::string_view rest) {
  const std::size_t end = std::min(rest.find(' '), rest.size());
  const std::optional<Named> named = model_.find(rest.substr(0, end));
  if (!named || named->kind != Named::Kind::Data)
    return refuse(fmt::format("`{}` is no data: COMPONENT.DATA", rest.substr(0, end)));
  const rt::AtomType& type = session_.core().tables().atom_type(named->owner);
  BIP_ASSERT(named->row < type.variables.size, "variable {} of {}", named->row, type.variables.size);
  const Result<rt::Cell> value =
      model_.parse_value(std::string(without_blanks(rest.substr(end))), type.variables[named->row].type);
  if (!value) return refuse(value.error());
  session_.mark();
  tell(session_.assign(named->owner, named->row, *value), Lines::Last);
}

// -- Looking --

void Console::list(std::string_view) {
  rt::Core& core = session_.core();
  if (session_.is_at_fault()) return refuse("the run has ended with an error: there are no candidates");
  const std::optional<std::uint64_t> recorded = session_.recorded_choice();
  if (core.candidate_count() > kMostCandidates) {
    // Names alone, which cost nothing to find.
    for (std::uint64_t k = 0; k < kMostCandidates; ++k) {
      std::string name;
      rt::append_candidate(name, core, core.candidate(k));
      output_.print(fmt::format("  {} [{}] {}\n", recorded == k ? '*' : ' ', k, name));
    }
    output_.print(fmt::format("    … and {} more\n", core.candidate_count() - kMostCandidates));
    return;
  }
  std::string text;
  rt::StepWriter().state(text, core);
  std::uint64_t k = 0;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    if (recorded == k++) text[at + 2] = '*';
  }
  BIP_ASSERT(k == core.candidate_count(), "{} lines of {} candidates", k, core.candidate_count());
  if (core.is_timed()) {
    const auto tell_candidate = [](std::string& out, rt::Core& of, const rt::Candidate& candidate) {
      rt::append_candidate(out, of, candidate);
    };
    for (const rt::FutureCandidate& later : rt::future_candidates(core, tell_candidate)) {
      if (later.intervals.empty() || later.intervals.front().has(core.now())) continue;
      text += "      later: " + later.text;
      for (const rt::Interval& interval : later.intervals) {
        text += ' ';
        rt::append_interval(text, interval);
      }
      text += '\n';
    }
  }
  output_.print(text.empty() ? "no candidates\n" : text);
}

void Console::print_atoms(std::string_view rest) {
  const std::string begin = rest.starts_with("ROOT.") ? std::string(rest.substr(5)) : std::string(rest);
  const rt::Core& core = session_.core();
  std::uint64_t count = 0;
  for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    const std::string path = core.image().atoms[atom].path();
    const std::string shown = rt::relative(path.c_str());
    if (!shown.starts_with(begin) || ++count > kMostAtoms) continue;
    std::string line = fmt::format("  {} at `{}`", shown, rt::places_of(core, atom));
    if (const std::string data = rt::data_of(core, atom); !data.empty()) line += "  " + data;
    output_.print(line + "\n");
  }
  if (count == 0) return refuse(fmt::format("there is no component whose path begins with `{}`", begin));
  if (count > kMostAtoms) output_.print(fmt::format("  … and {} more\n", count - kMostAtoms));
}

void Console::print_changes(std::string_view) {
  const rt::LastMove* const last = session_.last_move();
  if (last == nullptr) return refuse("no move led here");
  const rt::Core& core = session_.core();
  output_.print(last->text + "\n");
  for (const rt::AtomChange& change : last->changes) {
    const std::string path = core.image().atoms[change.atom].path();
    std::string line = fmt::format("  {}", rt::relative(path.c_str()));
    if (!change.places.empty()) line += fmt::format("  `{}` -> `{}`", change.places, rt::places_of(core, change.atom));
    const rt::AtomType& type = core.tables().atom_type(change.atom);
    BIP_ASSERT(change.variables.size() == change.values.size(), "{} values of {} variables", change.values.size(),
               change.variables.size());
    for (std::size_t k = 0; k < change.variables.size(); ++k) {
      const rt::u32 row = change.variables[k];
      std::string now;
      rt::append_value(now, core.image(), type.variables[row].type,
                       core.cell(core.image().atoms[change.atom].variable(row)));
      line += fmt::format("  {}: {} -> {}", type.variables[row].name, change.values[k], now);
    }
    output_.print(line + "\n");
  }
  if (last->changes.empty()) output_.print("  no place and no variable differs\n");
}

void Console::why(std::string_view rest) {
  const rt::Core& core = session_.core();
  if (session_.is_at_fault()) return refuse("the run has ended with an error", session_.fault());
  if (rest.empty()) {
    if (core.candidate_count() != 0)
      return refuse("this is no deadlock", "`y CONNECTOR` or `y COMPONENT.PORT` explains one");
    output_.print(rt::end_story(session_.core(), session_.position(), seed_));
    return;
  }
  const std::optional<Named> named = model_.find(rest);
  if (!named || (named->kind != Named::Kind::Connector && named->kind != Named::Kind::Port))
    return refuse(fmt::format("there is no connector and no port `{}`", rest));
  output_.print(named->kind == Named::Kind::Connector ? rt::why_not_connector(core, named->owner)
                                                      : rt::why_not_port(core, named->owner, named->row));
}

void Console::evaluate(std::string_view rest) {
  const Result<std::string> value = model_.evaluate(std::string(rest), session_.core());
  if (!value) return refuse(value.error());
  output_.print(*value + "\n");
}

void Console::display(std::string_view rest) {
  if (rest.empty()) {
    displays_.clear();
    return;
  }
  const Result<std::string> value = model_.evaluate(std::string(rest), session_.core());
  if (!value) return refuse(value.error());
  displays_.push_back({std::string(rest)});
  output_.print(fmt::format("  {} = {}\n", rest, *value));
}

void Console::set_breakpoint(std::string_view rest) {
  if (rest.empty()) {
    for (const rt::Breakpoint& b : session_.breakpoints())
      output_.print(fmt::format("  {}: {} ({})\n", b.number, b.text, rt::counted(b.hits, "hit")));
    if (session_.breakpoints().empty()) output_.print("no breakpoints\n");
    return;
  }
  Result<rt::Breakpoint> made = model_.parse_breakpoint(std::string(rest));
  if (!made) return refuse(fmt::format("`{}`: {}", rest, made.error()));
  made->number = output_.number_breakpoint ? output_.number_breakpoint() : next_breakpoint_++;
  output_.print(fmt::format("breakpoint {}: {}\n", made->number, made->text));
  session_.breakpoints().push_back(std::move(*made));
}

void Console::delete_breakpoint(std::string_view rest) {
  std::uint64_t number = 0;
  const bool is_number = read_number(rest, number);
  const std::size_t count =
      std::erase_if(session_.breakpoints(), [&](const rt::Breakpoint& b) { return is_number && b.number == number; });
  if (count == 0) refuse(fmt::format("there is no breakpoint `{}`", rest), "`m` lists them");
}

void Console::save(std::string_view rest) {
  if (rest.empty()) return refuse("`o` needs a file");
  std::string text;
  if (!session_.append_trace(text, rt::TraceFormat::Json)) return refuse(session_.problem());
  if (const std::string problem = output_.write(std::string(rest), text); !problem.empty())
    return refuse(fmt::format("cannot write `{}`: {}", rest, problem));
  output_.print(fmt::format("{} written to {}\n", rt::counted(session_.position(), "move"), rest));
}

void Console::help(std::string_view) {
  for (const Command& command : commands())
    output_.print(fmt::format("  {} {:<11} {}\n", command.letter, command.arguments, command.help));
  output_.print(
      "TARGET is a line (12, dine.bip:12), an instant (@1s500ms), a connector, COMPONENT.PORT, COMPONENT@PLACE, "
      "COMPONENT.DATA,\na condition or a property (never EXPR, always EXPR); ` if EXPR` may follow.\n");
}

}  // namespace bip::debug
