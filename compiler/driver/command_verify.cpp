// `bipc verify`: decides deadlock-freedom, run-time errors or a property (compiler/verify/portfolio/portfolio.hpp) and
// prints the verdict; of a model that states properties, those of all its questions.
//
// There are three verdicts. A property that holds has a proof, or every reachable state was visited; a counterexample
// has been replayed before it is printed; everything else is unknown, with the reason. Ctrl-C ends the command with the
// facts known so far.
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "compiler/base/json_text.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/answer_question.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/cache_folder.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/verdict_table.hpp"
#include "compiler/driver/verify_sizes.hpp"
#include "compiler/driver/write_certificate.hpp"
#include "compiler/pipeline/load_properties.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

// The run that violates the property, if one was found and a file was asked for.
void write_counterexample(const VerifyArguments& arguments, Compilation& c, const library::Verdict& verdict) {
  if (arguments.trace_path.empty() || !verdict.counterexample) return;
  if (const Result<bool> written = write_file(arguments.trace_path, verdict.counterexample->trace); !written)
    c.diags.report(Diag::kB5004, {}, arguments.trace_path, written.error());
}

struct NamedQuestion {
  std::string name;
  verify::Question question;
};

// What is asked: by `--property` and `--partial`, else whether there is a deadlock, and each property of the model.
std::optional<std::vector<NamedQuestion>> read_questions(const VerifyArguments& arguments, const System& system) {
  std::vector<NamedQuestion> questions;
  std::optional<verify::Question> asked =
      read_question(arguments.property, library::read_question(arguments, system), system);
  if (!asked) return std::nullopt;
  questions.push_back({"deadlock", std::move(*asked)});
  if (!arguments.property.empty() || arguments.partial || system.properties.empty()) return questions;
  const verify::PropertyReader reader(system);
  for (const StatedProperty& stated : system.properties) {
    Result<verify::Question> question = library::read_question(stated.text, reader);
    BIP_ENSURE(question, "property `{}` was checked: {}", stated.name, question.error());
    questions.push_back({stated.name, std::move(*question)});
  }
  return questions;
}

std::vector<DataRef> data_of(const std::vector<NamedQuestion>& questions) {
  std::vector<DataRef> data;
  for (const NamedQuestion& asked : questions) {
    const std::vector<DataRef> own = library::data_of(asked.question);
    data.insert(data.end(), own.begin(), own.end());
  }
  return data;
}

void write_files(const VerifyArguments& arguments, Compilation& c, const library::Verdict& verdict) {
  write_certificate(c, arguments.certificate, verdict);
  write_counterexample(arguments, c, verdict);
}

// A certificate and a run answer one question.
bool may_write_files(const VerifyArguments& arguments, const std::vector<NamedQuestion>& questions) {
  if (questions.size() == 1 || (arguments.certificate.empty() && arguments.trace_path.empty())) return true;
  std::string names;
  constexpr std::size_t kNamesShown = 6;
  for (std::size_t k = 0; k < questions.size() && k < kNamesShown; ++k)
    names += fmt::format("{}`{}`", k == 0 ? "" : ", ", questions[k].name);
  if (questions.size() > kNamesShown) names += ", …";
  usage_error(fmt::format("{} is of one answer, and {} are asked for",
                          arguments.certificate.empty() ? "--trace" : "--certificate", questions.size()),
              "choose one by --property: " + names);
  return false;
}

}  // namespace

int command_verify(const VerifyArguments& arguments) {
  if (!arguments.for_all.empty()) return verify_for_all_sizes(arguments);
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {arguments.certificate, arguments.trace_path}) ||
      !check_writable(c, {arguments.certificate, arguments.trace_path}))
    return report(c);
  if (!arguments.properties_path.empty() && !load_properties(c, arguments.properties_path)) return report(c);
  library::VerifyRequest request = arguments;
  request.wants_certificate = !arguments.certificate.empty();
  request.wants_trace = !arguments.trace_path.empty();
  request.wants_run = arguments.json;
  const std::optional<std::vector<NamedQuestion>> questions = read_questions(arguments, *c.system);
  std::optional<verify::Fairness> fairness = read_fairness(arguments.fair, *c.system);
  if (!questions || !fairness || !may_write_files(arguments, *questions)) return kUsage;
  request.fairness = std::move(*fairness);
  request.is_one_of_many = questions->size() > 1;
  if (request.reuses) warn_of_unusable_cache(c, c.options.cache);
  const std::string note = library::remove_unread_cpp(request, c, data_of(*questions));
  std::vector<NamedVerdict> verdicts;
  bool are_answered = true;
  for (const NamedQuestion& asked : *questions) {
    if (!are_answered) break;
    NamedVerdict row{asked.name, answer_question(request, c, asked.question, note)};
    write_files(arguments, c, row.verdict);
    are_answered = row.verdict.is_answered;
    verdicts.push_back(std::move(row));
  }
  if (const int code = report(c); code != 0 || !are_answered) return code;
  const library::Verdict& first = verdicts.front().verdict;
  const std::string text = verdicts.size() == 1
                               ? (arguments.json ? json_line(first.json) + '\n' : first.text_with_figures())
                           : arguments.json ? verdict_table_json(verdicts)
                                            : verdict_table(verdicts);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return worst_exit_code(verdicts);
}

}  // namespace bip::driver
