// The command line as data, with the defaults of the commands.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/graph/graph.hpp"
#include "compiler/traces/selection.hpp"
#include "compiler/library/verify_request.hpp"
#include "compiler/pipeline/options.hpp"
#include "compiler/library/sequential_test.hpp"
#include "compiler/serve/serve_options.hpp"
#include "runtime/engine/simulate.hpp"
#include "runtime/debug/session.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::driver {

using namespace pipeline;  // the commands are made of it

struct RunArguments {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Auto;
  Optimisation optimisation = Optimisation::Auto;
  rt::RunOptions run;
  bool for_debuggers = false;     // gdb and perf see machine code and its lines
  bool profile = false;           // a table of where the time went follows
  std::string profile_path;       // the same as JSON; empty: none
  std::string placement_path;     // where components are at home; empty: anywhere
  std::uint32_t split_above = 0;  // conflict sets of more interactions get several coordinators; 0: as usual
  std::string misplaced;          // an option of another engine, and of which; empty: none
};
/// Folders for the hosts of a run.
struct DeployArguments {
  CompileOptions compile;
  std::string file;
  std::string placement_path;
  std::string output;
};
/// Such a folder; `file` and `placement_path` of the run are in it.
struct NodeArguments : RunArguments {
  std::string folder;
  std::string listen;             // ADDRESS:PORT; empty: as the placement says
  std::int64_t stall_after = -1;  // ns; -1: a second if the model's C++ has a safe-stop function, else never
  std::string safe_stop;          // empty: `safe_stop` if the model's C++ has it
};
/// A debugging session on a model.
struct SessionArguments {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Interp;
  rt::SessionOptions session;
  std::string trace_path;  // empty: none
  std::string events_path;
};
/// On the console.
struct StepArguments : SessionArguments {
  bool has_at = false;
  std::uint64_t at = 0;
};
/// A page with the pictures of a model and a run of it.
struct ViewArguments : SessionArguments {
  std::string output;
  std::uint64_t steps = 200;  // without a trace
  std::string certificate;    // of verify --certificate; empty: none
  bool is_live = false;
  std::uint16_t port = 0;   // of a live page; 0: a free one
  std::string attached_to;  // a running `bipc serve`: SOCKET, PORT or PORT:TOKEN; empty: none
  graph::PictureOptions picture;
};
enum class TraceAction : std::uint8_t { Convert, Filter, Stats };
enum class TraceOutput : std::uint8_t { BySuffix, Json, Bip2, Binary, Mcap, Perfetto, Csv, Vcd, Svg };
/// A recorded run in another format, a part of it, or counts.
struct TraceArguments : SessionArguments {
  TraceAction action = TraceAction::Convert;
  std::string output;
  TraceOutput format = TraceOutput::BySuffix;
  bool json = false;      // Stats
  bool compress = false;  // Mcap
  traces::Selection selection;
};
/// A model that clients talk to.
struct ServeArguments : serve::ServeSettings {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Auto;
};
struct BuildArguments {
  CompileOptions compile;
  std::string file;
  std::string output;
  Optimisation optimisation = Optimisation::Auto;
  bool serves = false;  // the program serves the model, as `bipc serve` does
};
struct VerifyArguments : library::VerifyRequest {
  CompileOptions compile;
  std::string file;
  std::string properties_path;  // of a file with more properties; empty: none
  std::string certificate;      // empty: none is written
  std::string trace_path;       // of the run that violates the property; empty: none is written
  std::string fair = "none";    // its names are resolved in the model
  std::string for_all;          // parameter whose sizes are meant, `n` or `n >= 3`; empty: one system
  bool json = false;
};
struct ExploreArguments {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Auto;
  Optimisation optimisation = Optimisation::Auto;
  rt::ExploreOptions explore;
  std::uint64_t threads = 0;    // 0: all processors
  std::uint64_t megabytes = 0;  // 0: what the machine can spare
  std::uint64_t seconds = 0;    // 0: no limit
  std::string trace_path;       // of the way to the deadlock, else to the error
  rt::TraceFormat format = rt::TraceFormat::Steps;
  bool json = false;
  bool silent = false;  // only the last line
  bool stats = false;
  bool trusts_cpp = false;  // C++ functions depend on their arguments alone
};
struct SimulateArguments {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Auto;
  Optimisation optimisation = Optimisation::Auto;
  rt::SimulateOptions simulate;  // observers, stop and until are read from the texts below
  std::vector<std::string> observers;
  std::vector<std::string> queries;
  double confidence = 0.95;                        // of intervals
  library::TestOptions test;                       // of queries that are tests
  bool exact = false;                              // queries are answered on the Markov chain
  std::string importance;                          // queries are answered by splitting; empty: they are not
  std::vector<double> levels;                      // of splitting; empty: they are found
  std::uint64_t effort = 1000, replications = 32;  // of splitting
  bool has_runs = false, has_limit = false;        // else their defaults
  std::string stop, until;                         // empty: none
  double within = 0;                               // runs enough for a probability to be so near; 0: simulate.runs
  bool has_seed = false;                           // else one is drawn
  std::uint64_t threads = 0;                       // 0: all processors
  std::string csv_path;                            // a row a run; empty: none
  bool json = false;
  bool shows_histogram = false;
};
struct CheckArguments {
  CompileOptions compile;
  std::vector<std::string> files;
  std::string placement_path = {};  // what a distributed run of the file would be; empty: not asked for
  bool json = false;                // the answer to that
  std::string lesson = {};          // of the book, whose exercises the file solves, or not; empty: none
};
struct EmitArguments {
  CompileOptions compile;
  std::string file;
  std::string directory;  // empty: print the stage of compile.emit
  Optimisation optimisation = Optimisation::O2;
  bool has_no_main = false;  // of the C++ in the directory
  emit_cpp::CppBuild extra;  // files beside those of `@cpp`
  std::vector<std::string> link_folders, libraries;
};
enum class GraphFormat : std::uint8_t { BySuffix, Dot, Json, Svg, Png, Html };
/// What `bipc graph` shows: halves of a System, or the robot modules of descriptions.
enum class Shown : std::uint8_t { All, Structure, Automata, Modules };
struct GraphArguments {
  CompileOptions compile;          // folders are also those of headers
  std::vector<std::string> files;  // one model, or descriptions of modules
  Shown shown = Shown::All;
  std::string side_file;             // of descriptions; empty: none
  std::vector<std::string> defines;  // of their preprocessor
  std::string output;                // empty: standard output
  GraphFormat format = GraphFormat::BySuffix;
  graph::PictureOptions picture;
};
enum class ExportFormat : std::uint8_t { Promela, Pnml, Aiger, Net, Prism };
struct ExportArguments {
  CompileOptions compile;
  std::string file;
  std::string output;  // empty: standard output
  ExportFormat format = ExportFormat::Promela;
  std::string property;       // Aiger: what is bad; empty: a deadlock
  std::string fair = "none";  // Promela: the runs of which the property is asked
  // Transitions of a Petri net, states of a Markov chain; none: the format's default.
  std::optional<std::uint32_t> max_size;
  bool maximal_progress = true;
};
/// A file checked against a trace: of the published engine, or a binary one.
struct ReplayArguments {
  CompileOptions compile;
  std::string file;
  std::string published_trace, recorded_trace;  // one of them
  std::string resume_path;                      // of the recorded one: where that run went on
  rt::TraceFormat format = rt::TraceFormat::Steps;
  bool silent = false;
  Backend backend = Backend::Auto;
  bool maximal_progress = true;
};
struct MigrateArguments {
  CompileOptions compile;
  std::vector<std::string> files;
  std::string output;  // empty: standard output
  bool in_place = false;
};
struct FmtArguments {
  CompileOptions compile;
  std::vector<std::string> files;
  bool check = false;
  bool in_place = false;
};

/// Descriptions of robot modules to BIP, and rules over them: then `files` is the one .rules file.
struct GenomArguments {
  CompileOptions compile;  // diagnostics; folders are those of headers
  std::vector<std::string> files;
  std::string output;  // empty: standard output
  std::string side_file;
  std::string package;
  std::vector<std::string> defines;
  std::size_t instances = 1;
  std::string flavour;              // "", "verification" or "execution"
  bool executive = false;           // requests come from C++
  bool served = false;              // requests come from clients of `bipc serve`
  bool skeleton = false;            // empty codels beside the output
  std::vector<std::string> codels;  // files of genom3's C codels; empty: none
  bool task_threads = false;        // codels run beside the engine, and their tasks wait for them
  bool processes = false;           // codels of each module run in a process of its own
  std::int64_t kill_after = 0;      // ns
  std::int64_t module_memory = 0;   // MB
  std::string lock;                 // "", "module" or "codel"
  std::string design;               // "", or of the paper "first" or "repaired"
  double tick_ms = 0;
  std::int64_t control_period = 1;
  std::int64_t poster_period = 1;
  std::int64_t oldest = 100;
  bool prove = false;           // of rules: can they be met?
  bool reduced = false;         // of rules: the modules reduced to what they are about
  bool lists_left_out = false;  // of rules: which services are like theirs?
  std::uint64_t timeout = 60;
};

/// Robot modules in ROS: the bridge to a running `bipc serve`, or the package of their types.
struct BridgeArguments {
  GenomArguments level;              // descriptions, or one .rules file; `package` is that of the types
  std::string serve;                 // where `bipc serve` is; empty: no bridge
  std::string interfaces;            // folder for the package; empty: none
  std::vector<std::string> modules;  // empty: all
  std::string name_space;            // empty: none
  double rate = 10;
};
struct Ros2Arguments {
  BridgeArguments bridge;
  std::string network = "lo";  // "auto": as Cyclone DDS is configured
  std::int64_t domain = -1;    // -1: $ROS_DOMAIN_ID, or 0
};

/// The published tools' own call: bipc -p Package -I DIR -d 'Root()' [--gencpp-output DIR], or -f FILE.
struct PublishedArguments {
  CompileOptions compile;
  std::string package;
  std::string file;                      // instead of the package's
  std::vector<std::string> cpp_folders;  // --gencpp-cc-I: where files of `@cpp` are, too
  std::string cpp_output;
  bool has_no_main = false;
  std::vector<std::string> sources, objects, link_folders, libraries;  // linked into the emitted program
  std::vector<std::string> ignored;                                    // options that are taken and mean nothing here
};

enum class VersionFormat : std::uint8_t { Text, Json };
struct VersionArguments {
  VersionFormat format = VersionFormat::Text;
  std::string commit, llvm_version;
};

enum class Shell : std::uint8_t { Bash, Zsh, Fish };

}  // namespace bip::driver
