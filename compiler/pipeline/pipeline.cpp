// The pipeline: the table of passes below, one line per pass.
//
// Each pass reads the product of an earlier one and stores its own in the Compilation; it returns `false` if it
// reported errors. With --verify-each, and always in a checked build, a product is validated right after its pass; a
// violation is a bug of the compiler. --print-after prints the product of a pass that has a text form.
#include "compiler/pipeline/pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "compiler/base/stage_scope.hpp"
#include "compiler/pipeline/check_properties.hpp"
#include "compiler/pipeline/check_rest.hpp"
#include "compiler/pipeline/load_packages.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/pipeline/roots.hpp"
#include "compiler/model/validate_model.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/syntax/validate_syntax.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/instantiate.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"

namespace bip::pipeline {

Compilation::Compilation(CompileOptions o) : options(std::move(o)) {}
Compilation::~Compilation() = default;

namespace {

bool load_source(Compilation& c) {
  const Result<FileId> file = load_text(c, c.path);
  if (!file) {
    c.diags.report(Diag::kB0090, {}, c.path, file.error());
    return false;
  }
  c.file = *file;
  return true;
}

bool parse_source(Compilation& c) {
  if (c.is_bsys()) return true;
  c.syntax = parse_text(c, c.file);
  return c.syntax.has_value() && !c.diags.has_errors();
}

bool read_packages(Compilation& c) {
  if (c.is_bsys() || load_packages(c)) return true;
  if (c.syntax && c.syntax->package != nullptr) check_without_missing(c);
  return false;
}

bool parse_root(Compilation& c) {
  if (c.options.root.empty()) {
    const bool is_named = c.syntax && c.syntax->package != nullptr && !c.syntax->package->name.parts.empty();
    c.root_range = is_named ? c.syntax->package->name.range : SourceRange{.file = c.file, .begin = 0, .end = 0};
    return true;
  }
  c.root = parse::parse_root(c.sources, c.options.root, c.diags);
  if (!c.root) return false;
  const FileId text{c.sources.size() - 1};
  c.root_range = {.file = text, .begin = 0, .end = static_cast<std::uint32_t>(c.sources.text(text).size())};
  return !c.diags.has_errors();
}

bool build_model(Compilation& c) {
  if (c.is_bsys()) return true;
  c.model = model::build_model(c.packages, c.sources, c.diags);
  return c.model.has_value() && !c.diags.has_errors();
}

system::UnfoldingLimits unfolding_limits(const CompileOptions& options) {
  // What an atom or a connector takes until the model runs, with room to spare.
  constexpr std::uint64_t kBytesPerInstance = 1000;
  system::UnfoldingLimits limits;
  std::uint64_t wanted = options.max_instances;
  if (wanted == 0) wanted = std::max<std::uint64_t>(limits.instances, available_memory() / 4 * 3 / kBytesPerInstance);
  limits.instances = std::min<std::uint64_t>(wanted, system::kMostInstances);
  return limits;
}

void keep_system(Compilation& c, std::optional<System>&& system) {
  c.system = system ? std::make_unique<System>(std::move(*system)) : nullptr;
}

bool instantiate(Compilation& c) {
  if (c.is_bsys()) {
    Result<System> system = system::parse_bsys(c.sources.text(c.file));
    if (system) {
      c.system = std::make_unique<System>(std::move(*system));
    } else {
      c.diags.report(Diag::kB5005, {}, c.path, system.error());
    }
    return c.system != nullptr;
  }
  static const std::vector<const syntax::Expr*> kNoArguments;
  keep_system(c, system::instantiate(*c.model, c.root ? c.root->type : "", c.root ? c.root->args : kNoArguments,
                                     c.diags, c.root_range, unfolding_limits(c.options)));
  if (c.system && !c.diags.has_errors()) check_properties(*c.system, c.diags);
  return c.system != nullptr && !c.diags.has_errors();
}

// Broken promises of the products, none where a .bsys file has no such product.
std::vector<std::string> validate_syntax(const Compilation& c) {
  return c.syntax ? syntax::validate(*c.syntax, c.sources) : std::vector<std::string>();
}
std::vector<std::string> validate_packages(const Compilation& c) {
  std::vector<std::string> broken;
  for (const syntax::Syntax* package : c.packages) {
    for (std::string& promise : syntax::validate(*package, c.sources)) broken.push_back(std::move(promise));
  }
  return broken;
}
std::vector<std::string> validate_model(const Compilation& c) {
  return c.model ? model::validate(*c.model) : std::vector<std::string>();
}
std::vector<std::string> validate_system(const Compilation& c) { return system::validate(*c.system); }

std::string syntax_text(const Compilation& c) { return c.syntax ? syntax::dump(*c.syntax, c.sources) : std::string(); }
std::string model_text(const Compilation& c) { return c.model ? model::dump(*c.model) : std::string(); }
std::string system_text(const Compilation& c) { return system::print(*c.system); }

bool lower_system(Compilation& c) {
  // What comes from outside is a number, a truth value or a text.
  if (const std::string port = system::first_event_with_object(*c.system); !port.empty()) {
    c.diags.report(Diag::kB1801, c.root_range).note(port);
    return false;
  }
  c.root_name = name_of_root(c);
  c.lowered = lower::lower(*c.system, c.root_name);
  return true;
}

struct Pass {
  Stage stage;
  const char* name;
  bool (*run)(Compilation&);
  std::vector<std::string> (*validate)(const Compilation&) = nullptr;
  PrintAfter printed_as = PrintAfter::None;
  std::string (*text)(const Compilation&) = nullptr;  // for --print-after
};
constexpr Pass kPasses[] = {
    {Stage::Source, "load", load_source},
    {Stage::Syntax, "parse", parse_source, validate_syntax, PrintAfter::Parse, syntax_text},
    {Stage::Model, "load packages", read_packages, validate_packages},
    {Stage::Model, "parse root", parse_root},
    {Stage::Model, "build model", build_model, validate_model, PrintAfter::BuildModel, model_text},
    {Stage::System, "instantiate", instantiate, validate_system, PrintAfter::Instantiate, system_text},
    {Stage::Image, "lower", lower_system},
};

#ifdef BIP_CHECKED
constexpr bool kIsChecked = true;
#else
constexpr bool kIsChecked = false;
#endif

// What follows a pass that succeeded.
void inspect_product(Compilation& c, const Pass& pass) {
  if (pass.validate != nullptr && (c.options.verify_each || kIsChecked)) {
    const std::vector<std::string> broken = pass.validate(c);
    BIP_ENSURE(broken.empty(), "after pass `{}`: {}", pass.name, broken.front());
  }
  if (pass.text != nullptr && c.options.print_after == pass.printed_as) c.printed += pass.text(c);
}

// Runs one pass under a watch; a bug inside names it.
template <class Run>
bool timed(Compilation& c, const char* name, Run run) {
  using Clock = std::chrono::steady_clock;
  const StageScope doing(name, c.path);
  const Clock::time_point start = Clock::now();
  const bool sound = run();
  c.times.push_back({name, std::chrono::duration<double>(Clock::now() - start).count()});
  return sound;
}

}  // namespace

Result<FileId> load_text(Compilation& c, const std::string& path, std::string name) {
  const auto open = c.open_texts.find(path);
  Result<FileId> file = open == c.open_texts.end()
                            ? c.sources.load(path, std::move(name))
                            : c.sources.load_text(name.empty() ? path : std::move(name), open->second);
  if (file) c.paths[*file] = path;
  return file;
}

std::optional<syntax::Syntax> parse_text(Compilation& c, FileId file) {
  return parse::parse_file(c.sources, file, c.diags, c.kept == nullptr ? nullptr : &(*c.kept)[c.paths[file]]);
}

bool compile(Compilation& c, const std::string& path, Stage last) {
  c.path = path;
  for (const Pass& pass : kPasses) {
    BIP_ASSERT(&pass == std::begin(kPasses) || (&pass - 1)->stage <= pass.stage, "pass `{}` comes too late", pass.name);
    if (pass.stage > last) break;
    if (timed(c, pass.name, [&] { return pass.run(c); })) {
      inspect_product(c, pass);
      continue;
    }
    if (pass.stage == Stage::Syntax && last > Stage::Syntax) check_rest(c);
    return false;
  }
  return true;
}

bool check(Compilation& c, const std::string& path) {
  if (!c.options.root.empty() || path.ends_with(".bsys")) return compile(c, path, Stage::System);
  if (!compile(c, path, Stage::Model)) return false;
  const Pass& instantiation =
      *std::find_if(std::begin(kPasses), std::end(kPasses), [](const Pass& pass) { return pass.run == instantiate; });
  return timed(c, instantiation.name, [&c, &instantiation] {
    const system::UnfoldingLimits limits = unfolding_limits(c.options);
    bool is_first = true;
    for (const std::string& root : root_candidates(*c.model)) {
      // `instantiate` may take the model's code with it, so each root gets a model of its own. Nothing new can be said
      // about it; an error in another root's instances is none of it.
      Diagnostics known;
      if (!std::exchange(is_first, false)) c.model = model::build_model(c.packages, c.sources, known);
      keep_system(c, system::instantiate(*c.model, root, {}, c.diags, c.root_range, limits));
      if (c.system) {
        check_properties(*c.system, c.diags);
        inspect_product(c, instantiation);
      }
    }
    return !c.diags.has_errors();
  });
}

}  // namespace bip::pipeline
