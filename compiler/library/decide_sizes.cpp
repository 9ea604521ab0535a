// See decide_sizes.hpp. The order: the sizes below the least one that words stand for, and a few more, one by one; all
// from there on at once; if that proves nothing, further sizes one by one, for a part of the time.
#include "compiler/library/decide_sizes.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/verify_text.hpp"
#include "compiler/pipeline/error_sources.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/evidence/word_certificate.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/sizes/sized_compound.hpp"
#include "compiler/verify/sizes/word_problem.hpp"
#include "compiler/verify/sizes/word_proof.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

// Sizes tried for the first that compiles; those decided one by one at least, and where no proof was found.
constexpr std::int32_t kSizesTried = 8, kSizesAtLeast = 3, kSizesWithoutProof = 10;
// Beyond the description's least size, for certcheck to compare.
constexpr std::int64_t kSizesCompared = 2;

class SizeDecider {
 public:
  SizeDecider(const VerifyRequest& request, const Compilation& model, const CompoundType& type,
              const SizeQuestion& asked, const verify::CancellationToken& token)
      : request_(request), model_(model), type_(type), asked_(asked), token_(token.within(request.timeout)) {}

  SizeVerdict decide();
  SizeVerdict print();

 private:
  [[nodiscard]] std::unique_ptr<Compilation> compiled(std::int64_t size) const;
  [[nodiscard]] std::unique_ptr<Compilation> compile_first();
  // False: the verdict is complete.
  [[nodiscard]] bool decide_one(Compilation& c, std::int64_t size);
  [[nodiscard]] bool decide_up_to(std::int64_t size);
  [[nodiscard]] bool find_first();
  [[nodiscard]] bool prove_all();
  void answer(int exit_code, const std::string& name, std::string text);
  [[nodiscard]] std::string sizes_text() const;

  const VerifyRequest& request_;
  const Compilation& model_;
  const CompoundType& type_;
  const SizeQuestion& asked_;
  verify::CancellationToken token_;
  SizeVerdict out_;
  std::int64_t first_ = 0, next_ = 0;  // the sizes [first_, next_) have no deadlock
  std::optional<std::int64_t> deadlock_;
  std::size_t nodes_ = 0;
  bool can_fault_ = false;
  std::vector<std::string> certificates_;  // of the sizes from first_ on
  std::string certificate_of_all_;
  std::int64_t least_of_all_ = 0;
  std::string reason_;
  std::string run_data_;
};

std::unique_ptr<Compilation> SizeDecider::compiled(std::int64_t size) const {
  CompileOptions options = model_.options;
  options.root = fmt::format("{}({})", type_.name, size);
  auto c = std::make_unique<Compilation>(std::move(options));
  (void)compile(*c, model_.path, Stage::Image);
  return c;
}

void SizeDecider::answer(int exit_code, const std::string& name, std::string text) {
  Verdict& verdict = out_.verdict;
  verdict.is_answered = true;
  verdict.exit_code = exit_code;
  verdict.text = std::move(text);
  nlohmann::ordered_json json{
      {"format", "bipc-verdict"}, {"version", 1}, {"verdict", name}, {"for_all", asked_.parameter}, {"from", first_}};
  if (deadlock_) json["size"] = *deadlock_;
  if (next_ > first_) json["one_by_one_to"] = next_ - 1;
  if (exit_code == kOk) json["method"] = "invariants over words";
  if (nodes_ != 0) json["nodes"] = nodes_;
  if (exit_code == kUnknown) json["reason"] = reason_;
  json["text"] = verdict.text;
  verdict.json = std::move(json);
}

std::string SizeDecider::sizes_text() const {
  if (next_ == first_) return "";
  const std::string sizes = next_ == first_ + 1 ? fmt::format("{}", first_) : fmt::format("{}..{}", first_, next_ - 1);
  return fmt::format("; no deadlock at {} = {}", asked_.parameter, sizes);
}

bool SizeDecider::decide_one(Compilation& c, std::int64_t size) {
  BIP_ASSERT(size == next_ && certificates_.size() == static_cast<std::size_t>(next_ - first_),
             "size {} after {}, {} of which have certificates", size, next_ - 1, certificates_.size());
  VerifyRequest request = request_;
  request.property.clear();
  request.reuses = false;
  request.stats = false;
  if (request.backend == Backend::Auto) request.backend = Backend::Interp;
  request.timeout = std::max(token_.seconds_left(), 0.0);
  const verify::Question question;
  Verdict verdict;
  if (std::optional<Verdict> fault = decide_initial_fault(c, question)) verdict = std::move(*fault);
  else verdict = library::decide(request, c, question, "", token_, [](const char*, std::uint64_t, const char*) {});
  can_fault_ = can_fault_ || can_end_in_error(*c.system);
  if (verdict.is_answered && verdict.exit_code == kOk) {
    next_ = size + 1;
    certificates_.push_back(std::move(verdict.certificate));
    return true;
  }
  if (verdict.is_answered && verdict.exit_code == kViolated) {
    deadlock_ = size;
    out_.verdict.counterexample = std::move(verdict.counterexample);
    answer(kViolated, "deadlock", fmt::format("deadlock at {} = {}\n", asked_.parameter, size) + verdict.text);
    return false;
  }
  std::string line = verdict.text.substr(0, verdict.text.find('\n'));
  reason_ = fmt::format("{} = {} has no answer: {}", asked_.parameter, size, line);
  answer(kUnknown, "unknown", fmt::format("unknown: {}{}\n", reason_, sizes_text()));
  return false;
}

bool SizeDecider::decide_up_to(std::int64_t size) {
  while (next_ <= size) {
    const std::unique_ptr<Compilation> c = compiled(next_);
    if (c->diags.has_errors()) {
      const std::vector<const Diagnostic*> all = c->diags.sorted();
      const auto error =
          std::find_if(all.begin(), all.end(), [](const Diagnostic* d) { return d->severity == Severity::Error; });
      BIP_ENSURE(error != all.end(), "an error among {} diagnostics", all.size());
      reason_ = fmt::format("{} = {} does not compile: {}", asked_.parameter, next_, (*error)->message);
      answer(kUnknown, "unknown", fmt::format("unknown: {}{}\n", reason_, sizes_text()));
      return false;
    }
    if (!decide_one(*c, next_)) return false;
  }
  return true;
}

// Of the first size that compiles; null: none does.
std::unique_ptr<Compilation> SizeDecider::compile_first() {
  const std::int32_t low = asked_.least.value_or(1);
  const std::int32_t high = asked_.least ? low : kSizesTried;
  for (std::int32_t size = low; size <= high; ++size) {
    std::unique_ptr<Compilation> c = compiled(size);
    if (c->diags.has_errors()) {
      out_.refused = std::move(c);
      continue;
    }
    out_.refused.reset();
    first_ = next_ = size;
    return c;
  }
  return nullptr;
}

// The first size that compiles, and what it answers.
bool SizeDecider::find_first() {
  const std::unique_ptr<Compilation> c = compile_first();
  return c != nullptr && decide_one(*c, first_);
}

// All sizes from the description's least one on; false: reason_ says why not.
bool SizeDecider::prove_all() {
  Result<verify::SizedCompound> sized = verify::describe_sizes(*model_.model, type_);
  if (!sized) {
    reason_ = sized.error();
    return false;
  }
  const std::int64_t least = sized->least_size();
  const std::unique_ptr<Compilation> c = compiled(least), larger = compiled(least + 1);
  if (c->diags.has_errors() || larger->diags.has_errors() ||
      !verify::is_described_instance(*sized, *c->system, least) ||
      !verify::is_described_instance(*sized, *larger->system, least + 1)) {
    reason_ = fmt::format("the instance with {} = {} is not like the others", asked_.parameter, least);
    return false;
  }
  can_fault_ = can_fault_ || can_end_in_error(*c->system);
  const verify::Net net = verify::build_net(*c->system);
  Result<verify::WordProblem> problem = verify::make_word_problem(*sized, *model_.model, type_, net);
  if (!problem) {
    reason_ = problem.error();
    return false;
  }
  const verify::WordAnswer found = verify::prove_words(
      *problem, token_, request_.wants_certificate ? verify::WordEvidence::Sets : verify::WordEvidence::None);
  nodes_ = found.nodes;
  switch (found.outcome) {
    case verify::WordAnswer::Outcome::Proved:
      least_of_all_ = least;
      if (request_.wants_certificate)
        certificate_of_all_ = verify::certificate_of_sizes(*sized, net, found, c->root_name);
      return decide_up_to(least - 1);
    case verify::WordAnswer::Outcome::TooLarge: reason_ = found.reason; return false;
    case verify::WordAnswer::Outcome::Candidate:
      reason_ = "no invariant excludes " + verify::candidate_text(*sized, net, *problem, found, asked_.parameter);
      return false;
  }
  BIP_UNREACHABLE("an outcome");
}

SizeVerdict SizeDecider::decide() {
  if (!find_first() || !decide_up_to(first_ + kSizesAtLeast - 1)) return std::move(out_);
  if (prove_all()) {
    std::string text = fmt::format(
        "deadlock-free for every {} >= {}: proved by invariants over words ({} nodes), {} = {}..{} one by one\n",
        asked_.parameter, first_, nodes_, asked_.parameter, first_, next_ - 1);
    if (can_fault_) text += kErrorsNotAskedOfSizes;
    answer(kOk, "deadlock-free", std::move(text));
    if (request_.wants_certificate) {
      BIP_ASSERT(least_of_all_ <= next_, "all sizes from {} on, and one by one to {}", least_of_all_, next_ - 1);
      for (std::int64_t size = first_; size < least_of_all_; ++size)
        out_.verdict.certificate += certificates_[static_cast<std::size_t>(size - first_)];
      out_.verdict.certificate += certificate_of_all_;
    }
    return std::move(out_);
  }
  if (out_.verdict.is_answered) return std::move(out_);
  const std::string reason = reason_;
  if (!decide_up_to(first_ + kSizesWithoutProof - 1) && deadlock_) return std::move(out_);
  reason_ = reason;
  answer(kUnknown, "unknown", fmt::format("unknown: {}{}\n", reason_, sizes_text()));
  return std::move(out_);
}

// Without an answer: what would be asked.
SizeVerdict SizeDecider::print() {
  if (compile_first() == nullptr) return std::move(out_);
  Result<verify::SizedCompound> sized = verify::describe_sizes(*model_.model, type_);
  if (!sized) {
    reason_ = sized.error();
    answer(kUnknown, "unknown", fmt::format("unknown: {}\n", reason_));
    return std::move(out_);
  }
  std::string text;
  const std::int64_t least = sized->least_size();
  for (std::int64_t size = std::min(first_, least); size <= least + kSizesCompared; ++size) {
    std::unique_ptr<Compilation> c = compiled(size);
    if (c->diags.has_errors()) {
      out_.refused = std::move(c);
      return std::move(out_);
    }
    text += system::print(*c->system);
    text += size == least ? verify::for_all_rows(*sized, *model_.model, type_)
                          : fmt::format("(size {} {})\n", asked_.parameter, size);
  }
  answer(kOk, "systems", std::move(text));
  return std::move(out_);
}

// The compound type that the root names, or the only one whose one parameter is the size; none: the verdict says why.
const CompoundType* sized_type(const Compilation& model, const std::string& root, const SizeQuestion& asked,
                               SizeVerdict& none) {
  BIP_ASSERT(model.model.has_value(), "the file has a model");
  const std::string named = root.substr(0, root.find('('));
  const CompoundType* type = nullptr;
  std::size_t count = 0;
  std::string names, other;  // those of the parameter's name; one of another name
  for (const CompoundType& row : model.model->compound_types) {
    const bool is_own = row.decl->name.range.file == model.model->packages.back().file;
    const bool is_sized = row.params.size() == 1 && row.params.front().type == Type::Int;
    if (!is_own || !is_sized || (!named.empty() && row.name != named)) continue;
    if (row.params.front().name != asked.parameter) {
      other = fmt::format("; that of `{}` is `{}`", row.name, row.params.front().name);
      continue;
    }
    type = &row;
    names += (count++ == 0 ? "`" : ", `") + row.name + "`";
  }
  if (count == 1) return type;
  if (count == 0) {
    none.usage_error = fmt::format("no compound type{} has one parameter, `int {}`{}",
                                   named.empty() ? "" : " `" + named + "`", asked.parameter, other);
  } else {
    none.usage_error =
        fmt::format("{} have a parameter `int {}`: choose one by `--root {}`", names, asked.parameter, type->name);
  }
  return nullptr;
}

}  // namespace

Result<SizeQuestion> read_size_question(const std::string& text) {
  const auto trimmed = [](std::string_view part) {
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    while (!part.empty() && part.back() == ' ') part.remove_suffix(1);
    return part;
  };
  const std::size_t sign = text.find(">=");
  SizeQuestion asked;
  asked.parameter = std::string(trimmed(std::string_view(text).substr(0, sign)));
  bool is_read = !asked.parameter.empty() && asked.parameter.find_first_of(" <>=") == std::string::npos;
  if (sign != std::string::npos) {
    const std::string_view number = trimmed(std::string_view(text).substr(sign + 2));
    std::int32_t least = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), least);
    is_read = is_read && error == std::errc() && end == number.data() + number.size() && least >= 0 && least <= 1000;
    asked.least = least;
  }
  if (!is_read)
    return Failure{fmt::format("`{}` is neither the name of a parameter nor `NAME >= NUMBER` (at most 1000)", text)};
  return asked;
}

SizeVerdict decide_for_all_sizes(const VerifyRequest& request, const Compilation& model, const std::string& root,
                                 const SizeQuestion& asked, const verify::CancellationToken& token) {
  SizeVerdict none;
  const CompoundType* type = sized_type(model, root, asked, none);
  return type == nullptr ? std::move(none) : SizeDecider(request, model, *type, asked, token).decide();
}

SizeVerdict print_all_sizes(const Compilation& model, const std::string& root, const SizeQuestion& asked) {
  SizeVerdict none;
  const CompoundType* type = sized_type(model, root, asked, none);
  return type == nullptr ? std::move(none) : SizeDecider({}, model, *type, asked, {}).print();
}

}  // namespace bip::library
