// The Debug Adapter Protocol over a debugging session (`bipc dap`, compiler/docs/dap.md): requests in, responses and
// events out, both as bodies without their header (compiler/base/framing.hpp). Knows neither files nor streams.
//
// The model is one thread. The stack of a state is the step that led to it: the connector, then the transition of each
// component that took part. Malformed requests are answered with an error; nothing throws.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "compiler/debug/console.hpp"
#include "compiler/debug/debug_model.hpp"
#include "runtime/debug/session.hpp"
#include "runtime/include/bip/result.hpp"

namespace bip::debug {

/// What a `launch` asks for.
struct LaunchRequest {
  std::string program, root;
  std::string trace, events, policy;  // empty: none; uniform
  std::vector<std::string> folders;   // -I
  std::uint64_t seed = 0;
  bool asap = false, trusts_cpp = false, refuses_cpp = false;
};
/// A model that was compiled, with a started session; owns both.
struct Debuggee {
  virtual ~Debuggee() = default;
  rt::DebugSession* session = nullptr;
  std::unique_ptr<DebugModel> model;
};
/// Returns a model with its session, never null; the error says why the model cannot be run.
using Launch = std::function<Result<std::unique_ptr<Debuggee>>(const LaunchRequest& request)>;

class DapServer {
 public:
  DapServer(Launch launch, std::function<void(const std::string& body)> send);
  ~DapServer();
  DapServer(const DapServer&) = delete;
  DapServer& operator=(const DapServer&) = delete;

  /// Asked while the model runs: has a request come? Then run() returns.
  std::function<bool()> has_input;
  /// Answers one message.
  void handle(std::string_view body);
  /// Returns whether a request to run the model (`continue`, a step) is not finished: the caller then calls run().
  [[nodiscard]] bool is_running() const { return running_ != Running::No; }
  void run();
  [[nodiscard]] bool is_finished() const { return is_finished_; }

 private:
  using Json = nlohmann::json;
  enum class Running : std::uint8_t { No, Forward, Back };
  /// What a request is answered with: a body, or a problem.
  struct Answer;
  struct Request;
  static const std::vector<Request>& requests();

  Answer initialize(const Json& arguments);
  Answer launch(const Json& arguments);
  Answer set_breakpoints(const Json& arguments);
  Answer set_function_breakpoints(const Json& arguments);
  Answer data_breakpoint_info(const Json& arguments);
  Answer set_data_breakpoints(const Json& arguments);
  Answer set_exception_breakpoints(const Json& arguments);
  Answer configuration_done(const Json& arguments);
  Answer threads(const Json& arguments);
  Answer stack_trace(const Json& arguments);
  Answer scopes(const Json& arguments);
  Answer variables(const Json& arguments);
  Answer set_variable(const Json& arguments);
  Answer evaluate(const Json& arguments);
  Answer step(const Json& arguments);
  Answer step_in_targets(const Json& arguments);
  Answer step_back(const Json& arguments);
  Answer go_on(const Json& arguments);
  Answer go_back(const Json& arguments);
  Answer pause(const Json& arguments);
  Answer restart(const Json& arguments);
  Answer exception_info(const Json& arguments);
  Answer completions(const Json& arguments);
  Answer disconnect(const Json& arguments);

  void send_event(const char* name, Json body);
  void send_output(const std::string& text, const char* category);
  void stop_after(rt::Halt halt, const char* reason);
  void stop_at_breakpoint();
  void send_stopped(const std::string& reason, const std::string& text);
  void begin_session();
  [[nodiscard]] bool is_launched() const { return debuggee_ != nullptr; }
  [[nodiscard]] rt::DebugSession& session() { return *debuggee_->session; }
  [[nodiscard]] const DebugModel& model() const { return *debuggee_->model; }
  /// The request that set a breakpoint; Console: a command of the debug console, which none of them replaces.
  enum class Owner : std::uint8_t { Source, Function, Data, Exception, Console };
  void replace_breakpoints(Owner owner, const std::string& file);
  Json add_breakpoint(Owner owner, const std::string& file, rt::Breakpoint made, const Json& options);
  [[nodiscard]] std::uint32_t file_of(const std::string& path) const;
  [[nodiscard]] Json source_of(std::uint32_t file) const;
  [[nodiscard]] Json frame(int id, const std::string& name, rt::SourceLine loc) const;
  void append_atom(Json& rows, std::uint32_t atom) const;

  Launch launch_;
  std::function<void(const std::string& body)> send_;
  std::unique_ptr<Debuggee> debuggee_;
  std::unique_ptr<Console> console_;  // of the debug console, whose commands are those of `bipc step`
  std::string console_text_;
  LaunchRequest launched_;
  std::vector<std::string> files_;  // absolute, by row of Image::files
  struct Row {
    Owner owner = Owner::Source;
    std::string file;
  };
  std::vector<Row> owners_;  // by number of a breakpoint
  bool stops_on_entry_ = true, stops_on_fault_ = true, stops_on_deadlock_ = true;
  bool is_finished_ = false;
  Running running_ = Running::No;
  rt::Halt last_halt_ = rt::Halt::Done;
  // Of the breakpoints at which the model stopped last, which may be gone by now.
  std::vector<std::uint64_t> reached_numbers_;
  std::string reached_text_;
  std::uint64_t next_sequence_ = 1;
};

}  // namespace bip::debug
