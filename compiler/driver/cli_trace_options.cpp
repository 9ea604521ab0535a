// The options of `bipc trace`.
#include "compiler/driver/cli_options.hpp"
#include "compiler/driver/option_groups.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::driver {

namespace {

const Names<TraceAction> kActions{
    {"convert", TraceAction::Convert}, {"filter", TraceAction::Filter}, {"stats", TraceAction::Stats}};
const Names<TraceOutput> kOutputs{{"json", TraceOutput::Json},         {"bip2", TraceOutput::Bip2},
                                  {"binary", TraceOutput::Binary},     {"mcap", TraceOutput::Mcap},
                                  {"perfetto", TraceOutput::Perfetto}, {"csv", TraceOutput::Csv},
                                  {"vcd", TraceOutput::Vcd},           {"svg", TraceOutput::Svg}};

void add_instant(CLI::App& command, const char* name, std::int64_t& value, const char* help) {
  command
      .add_option_function<std::string>(
          name, [&value](const std::string& text) { value = rt::parse_time(text); }, help)
      ->check(CLI::Validator(
          [](std::string& text) { return rt::parse_time(text) >= 0 ? "" : "`" + text + "` is no instant: 1s500ms"; },
          ""))
      ->type_name("TIME");
}

}  // namespace

void add_trace(CLI::App& app, TraceArguments& a) {
  CLI::App* command =
      app.add_subcommand("trace", "convert a recorded run into another format, filter its steps, or count them");
  command
      ->add_option_function<std::string>(
          "ACTION", [&a](const std::string& text) { a.action = kActions.at(text); },
          "convert (all of the run), filter (the steps that the options say) or stats (counts of those steps)")
      ->check(CLI::Validator(
          [](std::string& text) { return kActions.contains(text) ? "" : not_one_of(text, "convert|filter|stats"); },
          ""))
      ->required()
      ->type_name("");
  command->add_option("MODEL", a.file, "the model of the run")->required()->type_name("");
  CLI::Option* trace = command->add_option("TRACE", a.trace_path,
                                           "the run: a trace in JSON lines, binary, bip2, MCAP or Perfetto, a "
                                           "counterexample of `bipc verify --trace`, or a record of `bipc "
                                           "run --record`");
  trace->required()->type_name("");
  command->add_option("-o,--output", a.output, "write to FILE (default: standard output); its suffix says the format")
      ->type_name("FILE");
  add_choice(*command, "--format", a.format, kOutputs, "json|bip2|binary|mcap|perfetto|csv|vcd|svg",
             "output format: json (JSON lines), bip2, binary, mcap and perfetto as of `bipc run`; csv (a row for each "
             "component that takes part), vcd (waves of places and data), svg (a sequence chart)");
  command->add_flag("--compress", a.compress, "mcap: compress the chunks (zstd)");
  command->add_flag("--json", a.json, "stats: print JSON");
  command
      ->add_option("--component", a.selection.components,
                   "only steps in which PATH, or something in it, takes part; may be repeated")
      ->allow_extra_args(false)
      ->type_name("PATH");
  command
      ->add_option("--interaction", a.selection.interactions,
                   "only steps of the connector PATH, or of all of the array PATH; may be repeated")
      ->allow_extra_args(false)
      ->type_name("PATH");
  add_number(*command, "--first", a.selection.first, "only steps from number N on (the first one is 0)");
  add_number(*command, "--last", a.selection.last, "only steps up to number N");
  add_instant(*command, "--after", a.selection.begin, "only steps from TIME on");
  add_instant(*command, "--until", a.selection.end, "only steps up to TIME");
  add_session(*command, a, trace);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc trace filter model.bip run.jsonl --component phil[0] -o phil.vcd");
}

}  // namespace bip::driver
