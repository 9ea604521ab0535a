// The console of a debugging session (`bipc step`, compiler/docs/step.md): commands of one letter, their answers as
// text.
//
// The class reads no input: its owner passes it lines. It writes answers and error messages through ConsoleOutput. It
// cuts long lists and prints how many rows are left out.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/debug/debug_model.hpp"
#include "runtime/debug/session.hpp"

namespace bip::debug {

/// Where the console's text goes. refuse: a command that was not executed, and a help (may be empty).
struct ConsoleOutput {
  std::function<void(std::string_view)> print;
  std::function<void(const std::string& problem, const std::string& help)> refuse;
  /// Writes a file; returns an empty text, or what is wrong.
  std::function<std::string(const std::string& path, const std::string& text)> write;
  /// Gives the next breakpoint its number, where breakpoints of others have numbers too. May be empty: from 1 on.
  std::function<std::uint64_t()> number_breakpoint;
};

class Console {
 public:
  /// The session has been started; all must outlive the console.
  Console(rt::DebugSession& session, const DebugModel& model, std::uint64_t seed, ConsoleOutput output);

  enum class Next : std::uint8_t { GoOn, Quit };
  /// Executes one line.
  Next execute(std::string_view line);
  /// Prints where the session is: at the begin, after a trace was loaded.
  void print_state();
  /// What follows the last word of the line, for Tab.
  [[nodiscard]] std::vector<std::string> complete(const std::string& word) const;
  /// `bipc step #12> `
  [[nodiscard]] std::string prompt() const;

 private:
  struct Command;
  static const std::vector<Command>& commands();

  struct WatchRow {
    std::string text;
  };

  // Commands.
  void step(std::string_view rest);
  void back(std::string_view rest);
  void list(std::string_view rest);
  void choose(std::string_view rest);
  void run(std::string_view rest);
  void run_back(std::string_view rest);
  void go_to(std::string_view rest);
  void restart(std::string_view rest);
  void walk(std::string_view rest);
  void undo(std::string_view rest);
  void print_atoms(std::string_view rest);
  void print_changes(std::string_view rest);
  void why(std::string_view rest);
  void evaluate(std::string_view rest);
  void display(std::string_view rest);
  void set_breakpoint(std::string_view rest);
  void delete_breakpoint(std::string_view rest);
  void pass_time(std::string_view rest);
  void post_event(std::string_view rest);
  void assign(std::string_view rest);
  void save(std::string_view rest);
  void help(std::string_view rest);

  void refuse(const std::string& problem, const std::string& help = {});
  [[nodiscard]] bool read_count(std::string_view rest, std::uint64_t without, std::uint64_t& count);
  enum class Lines : std::uint8_t { Last, None };
  void tell(rt::Halt halt, Lines lines);
  void print_last_move();
  void print_where();
  void take_steps(std::uint64_t count);
  void print_displays();
  void add_temporary(rt::Breakpoint breakpoint);
  void remove_temporary();
  [[nodiscard]] bool add_target(std::string_view rest);

  rt::DebugSession& session_;
  const DebugModel& model_;
  std::uint64_t seed_;
  ConsoleOutput output_;
  std::vector<WatchRow> displays_;
  std::uint64_t next_breakpoint_ = 1;
};

}  // namespace bip::debug
