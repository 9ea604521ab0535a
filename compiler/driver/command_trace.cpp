// `bipc trace`: a recorded run in another format, a part of it, or counts (compiler/docs/traces.md). The run is
// repeated on the model, so that what a trace leaves out (places, data) is there.
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/base/write_file.hpp"
#include "compiler/debug/back_refusal.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/open_session.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/traces/compress_chunk.hpp"
#include "compiler/traces/part_of_trace.hpp"
#include "compiler/traces/run_statistics.hpp"
#include "compiler/traces/run_writer.hpp"
#include "runtime/core/text.hpp"
#include "runtime/trace/mcap.hpp"

namespace bip::driver {

namespace {

// Nothing: the name of the file does not say it.
std::optional<TraceOutput> output_of(const TraceArguments& arguments) {
  if (arguments.format != TraceOutput::BySuffix) return arguments.format;
  if (arguments.output.empty() || arguments.output == "-") return TraceOutput::Json;
  const std::string suffix = std::filesystem::path(arguments.output).extension().string();
  constexpr std::pair<std::string_view, TraceOutput> kSuffixes[] = {
      {".jsonl", TraceOutput::Json}, {".json", TraceOutput::Json}, {".bin", TraceOutput::Binary},
      {".mcap", TraceOutput::Mcap},  {".csv", TraceOutput::Csv},   {".vcd", TraceOutput::Vcd},
      {".svg", TraceOutput::Svg}};
  for (const auto& [name, format] : kSuffixes)
    if (suffix == name) return format;
  return std::nullopt;
}

// The format of the runtime, if it is one of those.
std::optional<rt::TraceFormat> trace_format(TraceOutput output) {
  switch (output) {
    case TraceOutput::Json: return rt::TraceFormat::Json;
    case TraceOutput::Bip2: return rt::TraceFormat::Bip2;
    case TraceOutput::Binary: return rt::TraceFormat::Binary;
    case TraceOutput::Mcap: return rt::TraceFormat::Mcap;
    case TraceOutput::Perfetto: return rt::TraceFormat::Perfetto;
    case TraceOutput::BySuffix:
    case TraceOutput::Csv:
    case TraceOutput::Vcd:
    case TraceOutput::Svg: break;
  }
  return std::nullopt;
}

traces::WrittenAs written_as(TraceOutput output) {
  if (output == TraceOutput::Csv) return traces::WrittenAs::Csv;
  return output == TraceOutput::Vcd ? traces::WrittenAs::Vcd : traces::WrittenAs::Chart;
}

// "ROOT.k"; of an internal port "p.eat", as step lines have it.
std::string interaction_of(const rt::Core& core, const rt::LastMove& move) {
  const rt::Image& image = core.image();
  if (move.connector != rt::kNone) return image.connectors[move.connector].path();
  BIP_ASSERT(!move.parts.empty(), "`{}` moves no atom", move.text);
  std::string name;
  rt::append_relative(name, image.atoms[move.parts.front().atom]);
  return name + '.' + core.tables().atom_type(move.parts.front().atom).ports[move.parts.front().port].name;
}

// Repeats the run from its begin; visit(step) after each step. What is no step (time that passes, events) is passed
// over.
template <class Visit>
void visit_steps(rt::DebugSession& session, std::uint64_t length, const Visit& visit) {
  session.track(rt::Tracking::Every);
  std::uint64_t number = 0;
  while (session.position() < length) {
    const std::uint64_t before = session.position();
    (void)session.step();
    const rt::LastMove* const move = session.last_move();
    if (session.position() == before || move == nullptr) return;
    if (move->kind != rt::MoveKind::Step) continue;
    visit(traces::TracedStep{number++, session.core().now(), interaction_of(session.core(), *move), &move->parts});
  }
}

}  // namespace

int command_trace(const TraceArguments& arguments) {
  const traces::Selection& selection = arguments.selection;
  const std::optional<TraceOutput> output = output_of(arguments);
  const bool counts = arguments.action == TraceAction::Stats;
  if (!counts && !output)
    return usage_error(
        "the suffix of `" + arguments.output + "` says no format: .jsonl, .bin, .mcap, .csv, .vcd or .svg",
        "`--format` says it for any name");
  if (arguments.action == TraceAction::Convert && !selection.is_all())
    return usage_error("convert writes all of the run", "`bipc trace filter` writes a part of it");
  if (arguments.json && !counts) return usage_error("--json is of stats", "`--format json` writes JSON lines");
  if (counts && arguments.format != TraceOutput::BySuffix)
    return usage_error("stats has no --format", "`--json` prints JSON");
  if (arguments.compress && (counts || *output != TraceOutput::Mcap)) return usage_error("--compress is of mcap");
  if (arguments.compress && !traces::has_zstd()) return usage_error("this bipc was built without libzstd");
  const std::optional<rt::TraceFormat> format = counts ? std::nullopt : trace_format(*output);
  if (!counts && arguments.action == TraceAction::Filter &&
      (*output == TraceOutput::Bip2 || *output == TraceOutput::Binary))
    return usage_error("a part of a run can be written as json, mcap, perfetto, csv, vcd or svg",
                       "the other formats are read as whole runs: `bipc trace convert`");

  Compilation c(arguments.compile);
  Executor executor;
  rt::SessionOptions options = arguments.session;
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {arguments.output}) ||
      !check_writable(c, {arguments.output}))
    return report(c);
  if (const std::string unknown = selection.unknown(c.lowered->image); !unknown.empty()) {
    (void)report(c);
    return usage_error("the model has no " + unknown);
  }
  const OpenSession opened = open_session(c, executor, arguments, options);
  if (opened.session == nullptr) return opened.exit_code;
  rt::DebugSession& session = *opened.session;
  // A run that ends with an error is written up to there.
  if (session.is_at_fault() && format && session.position() > 0) (void)session.back(1);
  const std::uint64_t length = session.position();
  std::string text;
  rt::McapWriter mcap(arguments.compress ? rt::McapWriter::Compression{"zstd", traces::zstd}
                                         : rt::McapWriter::Compression{});
  const auto cannot_repeat = [&session] {
    return usage_error("the run cannot be repeated: " + session.problem(), debug::kGoesBackHelp);
  };
  // Which steps are in a part is known before it is written: of MCAP files, which are not cut afterwards.
  const bool is_part_of_mcap = format && *output == TraceOutput::Mcap && !selection.is_all();
  if (format && !is_part_of_mcap) {
    if (!(*output == TraceOutput::Mcap ? session.append_trace(text, *format, mcap)
                                       : session.append_trace(text, *format)))
      return cannot_repeat();
  }
  if (!format || !selection.is_all()) {
    if (session.go_to(0) == rt::Halt::Refused) return cannot_repeat();
    traces::RunStatistics statistics(selection);
    std::unique_ptr<traces::RunWriter> writer;
    std::vector<bool> wanted;
    if (counts) statistics.begin(session.core());
    else if (!format) writer = traces::make_run_writer(written_as(*output), *c.system, selection);
    if (writer != nullptr) writer->begin(text, session.core());
    visit_steps(session, length, [&](const traces::TracedStep& step) {
      using Wanted = traces::RunWriter::Wanted;
      const bool is_wanted = selection.takes(c.lowered->image, step);
      if (counts) statistics.step(session.core(), step);
      else if (writer != nullptr) writer->step(text, session.core(), step, is_wanted ? Wanted::Yes : Wanted::No);
      else wanted.push_back(is_wanted);
    });
    if (counts) text = arguments.json ? statistics.json().dump(2) + "\n" : statistics.text();
    else if (is_part_of_mcap) {
      traces::PartSink part(mcap, std::move(wanted));
      if (!session.append_trace(text, *format, part)) return cannot_repeat();
    } else if (writer == nullptr) {
      text = *output == TraceOutput::Json ? traces::wanted_lines(text, wanted)
                                          : traces::wanted_events(text, wanted, selection);
    } else if (const std::string problem = writer->problem(); !problem.empty()) return usage_error(problem);
    else writer->end(text);
  }
  if (arguments.output.empty() || arguments.output == "-") {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else if (const auto written = write_file(arguments.output, text); !written) {
    c.diags.report(Diag::kB5004, {}, arguments.output, written.error());
  }
  return report(c);
}

}  // namespace bip::driver
