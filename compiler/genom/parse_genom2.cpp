// GenoM 2 descriptions, by recursive descent. Attribute words are words before a `:`, so that `type` or `period` may be
// names elsewhere. C declarations are skipped: nothing of the mapping depends on the layout of data.
#include <array>
#include <map>
#include <set>

#include "compiler/genom/c_structs.hpp"
#include "compiler/genom/cursor.hpp"
#include "compiler/genom/parse_genom.hpp"

namespace bip::genom {
namespace {

// Spellings of older versions.
const std::map<std::string_view, std::string_view> kSynonyms{{"incompatible_with", "interrupt_activity"},
                                                             {"fail_msg", "fail_reports"},
                                                             {"c_control_func", "codel_control"},
                                                             {"c_exec_func", "codel_main"},
                                                             {"c_exec_func_start", "codel_start"},
                                                             {"c_exec_func_end", "codel_end"},
                                                             {"c_exec_func_fail", "codel_fail"},
                                                             {"c_exec_func_inter", "codel_inter"},
                                                             {"c_init_func", "codel_task_start"},
                                                             {"c_func", "codel_task_main"},
                                                             {"c_end_func", "codel_task_end"},
                                                             {"c_create_func", "codel_poster_create"}};

constexpr std::int64_t kMaxTicks = 1'000'000'000;

// The states of an activity of GenoM 2 in the order in which they are listed here.
constexpr std::array<std::string_view, 5> kStates{"START", "EXEC", "END", "INTER", "FAIL"};
constexpr std::array<std::string_view, 5> kCodels{"codel_start", "codel_main", "codel_end", "codel_inter",
                                                  "codel_fail"};
// What a codel of each may answer (GenoM 2's activities, compiler/docs/genom.md). The first is what a missing codel
// does.
const std::array<std::vector<std::string_view>, 5> kPermitted{
    {{"EXEC", "START", "END", "ETHER", "FAIL", "ZOMBIE", "SLEEP"},
     {"END", "EXEC", "ETHER", "FAIL", "ZOMBIE", "SLEEP"},
     {"ETHER", "END", "FAIL", "ZOMBIE"},
     {"ETHER", "INTER", "FAIL", "ZOMBIE"},
     {"ZOMBIE"}}};

Yield yield_of(std::string_view word) {
  if (word == "ETHER") return {Next::Ether, {}, 0};
  if (word == "ZOMBIE") return {Next::Zombie, {}, 0};
  if (word == "SLEEP") return {Next::Sleep, {}, 0};
  return {Next::State, {std::string(word), {}}, 0};
}

class Genom2Parser {
 public:
  Genom2Parser(const std::vector<Token>& tokens, Headers headers, Diagnostics& diags)
      : in_(tokens, diags), diags_(diags), first_(tokens.front().range) {
    module_.structs = read_c_structs(tokens);
    module_.is_open = headers == Headers::Missing;
  }

  Module run() {
    while (!in_.at_end()) {
      if (!declaration()) {
        if (in_.at("}")) in_.take();
        in_.skip_past_semicolon();
      }
    }
    if (!module_.name.is_set() && !diags_.has_errors()) diags_.report(Diag::kB6014, first_, "module");
    for (Task& t : module_.tasks) {
      t.period_us *= module_.tick_us;
      t.delay_us *= module_.tick_us;
    }
    return std::move(module_);
  }

 private:
  using Attribute = bool (Genom2Parser::*)(std::string_view word);

  bool declaration() {
    if (in_.at("module")) return block("module", module_.name, &Genom2Parser::module_attribute);
    if (in_.at("request")) return request();
    if (in_.at("exec_task")) return task();
    if (in_.at("poster")) return poster();
    if (in_.at("import")) return import();
    if (in_.accept(";")) return true;
    return c_declaration();
  }

  // typedef struct …; and whatever else a header holds: up to its `;`, over braces, or over a function's body.
  bool c_declaration() {
    if (in_.peek().kind != TokenKind::Word) {
      in_.unexpected("`module`, `request`, `exec_task`, `poster` or a type");
      in_.take();
      return false;
    }
    static const std::set<std::string_view> kBegins{"typedef", "struct",   "union",  "enum",  "extern", "static",
                                                    "const",   "unsigned", "signed", "int",   "char",   "double",
                                                    "float",   "void",     "long",   "short", "inline"};
    const Name word{std::string(in_.peek().text), in_.peek().range};
    if (!kBegins.contains(word.text) && in_.peek(1).is("{")) {
      diags_.report(Diag::kB6000, word.range, "`module`, `request`, `exec_task`, `poster` or a type",
                    "`" + word.text + "`");
      return false;
    }
    while (!in_.at_end() && !in_.at(";")) {
      if (in_.at("{")) {
        if (!in_.skip_group()) return true;
      } else if (in_.at("}")) {
        return in_.expect(";");
      } else {
        in_.take();
      }
    }
    return in_.expect(";");
  }

  bool import() {
    in_.take();
    if (in_.accept("from")) {
      Name ignored;
      if (!in_.name(ignored, "the name of a module")) return false;
    }
    if (!in_.at("{")) return in_.expect("{");
    return in_.skip_group() && in_.expect(";");
  }

  // WORD name { attribute: …; … };
  bool block(std::string_view kind, Name& name, Attribute attribute) {
    in_.take();
    if (!in_.name(name, fmt::format("the name of a {}", kind))) return false;
    owner_ = fmt::format("{} `{}`", kind, name.text);
    if (!in_.expect("{")) return false;
    seen_.clear();
    while (!in_.at("}") && !in_.at_end()) {
      if (!one_attribute(attribute)) in_.skip_past_semicolon();
    }
    return in_.expect("}") && in_.expect(";");
  }

  bool one_attribute(Attribute attribute) {
    Name word;
    if (!in_.name(word, "an attribute")) {
      in_.take();
      return false;
    }
    const auto synonym = kSynonyms.find(word.text);
    const std::string_view known = synonym == kSynonyms.end() ? std::string_view(word.text) : synonym->second;
    const auto [first, is_new] = seen_.try_emplace(std::string(known), word.range);
    if (!is_new) diags_.report(Diag::kB6005, word.range, word.text, owner_).label(first->second, "the first one");
    here_ = word;
    if (!in_.at(":")) {
      in_.unexpected(fmt::format("`:` after `{}`", word.text));
      return false;
    }
    in_.take();
    return (this->*attribute)(known) && in_.expect(";");
  }

  bool unknown_attribute(const std::vector<std::string>& known) {
    auto d = diags_.report(Diag::kB6011, here_.range, here_.text, owner_);
    for (const std::string& similar : similar_names(here_.text, known))
      d.help(fmt::format("there is `{}`", similar), here_.range, similar);
    return false;
  }

  // Anything up to the `;`; its words, without those in braces.
  bool skip(std::vector<std::string>* words = nullptr) {
    while (!in_.at_end() && !in_.at(";") && !in_.at("}")) {
      if (in_.at("{")) {
        if (!in_.skip_group()) return false;
      } else {
        const Token& token = in_.take();
        if (words != nullptr) words->emplace_back(token.text);
      }
    }
    return true;
  }

  bool module_attribute(std::string_view word) {
    static const std::vector<std::string> kKnown{"number",        "internal_data", "version",         "email",
                                                 "iface_version", "requires",      "codels_requires", "lang",
                                                 "uses_cxx",      "codel_files",   "clock_rate",      "stack_size"};
    std::int64_t value = 0;
    if (word == "number") return in_.number(value, ";}", 1, 32767, "the number of a module");
    if (word == "clock_rate") {
      if (!in_.number(value, ";}", 1, 1'000'000, "`clock_rate`")) return false;
      module_.tick_us = 1'000'000 / value;
      return true;
    }
    if (word == "internal_data") {
      std::vector<std::string> words;
      const bool is_whole = skip(&words);
      for (const std::string& each : words) module_.data_type += (module_.data_type.empty() ? "" : " ") + each;
      return is_whole;
    }
    for (const std::string& known : kKnown) {
      if (word == known) return skip();
    }
    return unknown_attribute(kKnown);
  }

  bool request() {
    codels_ = {};
    type_ = {};
    request_ = {};
    Name name;
    const bool whole = block("request", name, &Genom2Parser::request_attribute);
    if (!name.is_set()) return whole;
    request_.name = name;
    if (!seen_.contains("type"))
      diags_.report(Diag::kB6007, name.range, owner_, "type").help("`type: exec;`, `type: control;` or `type: init;`");
    finish_request();
    module_.services.push_back(std::move(request_));
    return whole;
  }

  bool request_attribute(std::string_view word) {
    static const std::vector<std::string> kKnown{
        "type",         "input",     "output",      "posters_input", "codel_control",      "codel_start",
        "codel_main",   "codel_end", "codel_inter", "codel_fail",    "interrupt_activity", "exec_task",
        "fail_reports", "resources", "doc",         "input_info"};
    if (word == "type") {
      type_ = in_.peek().text;
      if (type_ != "exec" && type_ != "control" && type_ != "init") {
        type_ = "control";
        in_.unexpected("`exec`, `control` or `init`");
        return false;
      }
      in_.take();
      return true;
    }
    if (word == "codel_control") return in_.name(request_.validate.name, "the name of a codel");
    for (std::size_t i = 0; i < kCodels.size(); ++i) {
      if (word == kCodels[i]) return in_.name(codels_[i], "the name of a codel");
    }
    if (word == "exec_task") return in_.name(request_.task, "the name of an execution task");
    if (word == "fail_reports") return in_.names(request_.reports, "a report");
    if (word == "interrupt_activity") {
      if (in_.accept("none")) return true;
      request_.interrupts_all = in_.accept("all");
      return request_.interrupts_all || in_.names(request_.interrupts, "`all`, `none` or the name of a request");
    }
    if (word == "doc") return doc();
    for (const std::string& known : kKnown) {
      if (word == known) return skip();
    }
    return unknown_attribute(kKnown);
  }

  bool doc() {
    if (in_.peek().kind != TokenKind::String) {
      in_.unexpected("a string");
      return false;
    }
    while (in_.peek().kind == TokenKind::String) request_.doc += in_.take().text;
    return true;
  }

  void finish_request() {
    Service& s = request_;
    bool has_codels = false;
    for (const Name& codel : codels_) has_codels = has_codels || codel.is_set();
    s.is_init = type_ == "init";
    // An `init` without task or codels is a control request.
    s.kind = type_ == "exec" || (s.is_init && (s.task.is_set() || has_codels)) ? ServiceKind::Execution
                                                                               : ServiceKind::Control;
    if (s.is_init) {
      s.interrupts_all = true;
      if (init_.is_set()) diags_.report(Diag::kB6009, s.name.range).label(init_.range, "the first one");
      init_ = s.name;
    }
    if (s.kind == ServiceKind::Control) {
      // Its one codel is run after what it interrupts was told to stop.
      if (s.validate.name.is_set()) s.body.push_back(std::move(s.validate));
      s.validate = {};
      return;
    }
    if (!s.task.is_set() && !seen_.contains("exec_task"))
      diags_.report(Diag::kB6007, s.name.range, owner_, "exec_task");
    for (std::size_t i = 0; i < kStates.size(); ++i) {
      State state{{std::string(kStates[i]), {}}, {codels_[i], {}}, {}};
      for (const std::string_view word : kPermitted[i]) {
        state.yields.push_back(yield_of(word));
        if (!codels_[i].is_set()) break;
      }
      s.activity.states.push_back(std::move(state));
    }
    s.activity.start = 0;
    s.activity.stop = 3;
  }

  bool task() {
    task_ = {};
    Name name;
    const bool whole = block("exec_task", name, &Genom2Parser::task_attribute);
    if (name.text == "test") diags_.report(Diag::kB6012, name.range, name.text);
    task_.name = name;
    if (name.is_set()) module_.tasks.push_back(std::move(task_));
    return whole;
  }

  bool task_attribute(std::string_view word) {
    static const std::vector<std::string> kKnown{
        "period",           "delay",           "priority",         "stack_size",
        "codel_task_start", "codel_task_main", "codel_task_main2", "codel_task_wait",
        "codel_task_end",   "posters_input",   "cs_client_from",   "poster_client_from",
        "resources",        "fail_reports"};
    std::int64_t ignored = 0;
    if (word == "period" || word == "delay") {
      if (in_.accept("none")) return true;
      return in_.number(word == "period" ? task_.period_us : task_.delay_us, ";}", 0, kMaxTicks,
                        fmt::format("`{}`", word));
    }
    if (word == "priority") return in_.number(ignored, ";}", 0, 255, "`priority`");
    if (word == "codel_task_main") return in_.name(task_.permanent.name, "the name of a codel");
    for (const std::string& known : kKnown) {
      if (word == known) return skip();
    }
    return unknown_attribute(kKnown);
  }

  bool poster() {
    poster_ = {};
    Name name;
    const bool whole = block("poster", name, &Genom2Parser::poster_attribute);
    poster_.name = name;
    if (!name.is_set()) return whole;
    if (!poster_.task.is_set() && !seen_.contains("exec_task"))
      diags_.report(Diag::kB6007, name.range, owner_, "exec_task");
    module_.posters.push_back(std::move(poster_));
    return whole;
  }

  bool poster_attribute(std::string_view word) {
    static const std::vector<std::string> kKnown{"update",    "data",    "type",
                                                 "exec_task", "address", "codel_poster_create"};
    if (word == "update") {
      poster_.is_auto = in_.at("auto");
      if (in_.accept("auto") || in_.accept("user")) return true;
      in_.unexpected("`auto` or `user`");
      return false;
    }
    if (word == "exec_task") return in_.name(poster_.task, "the name of an execution task");
    if (word == "data") {
      std::vector<std::string> words;
      const bool is_whole = skip(&words);
      poster_.data = read_data_refs(words);
      return is_whole;
    }
    for (const std::string& known : kKnown) {
      if (word == known) return skip();
    }
    return unknown_attribute(kKnown);
  }

  Cursor in_;
  Diagnostics& diags_;
  SourceRange first_;
  Module module_;
  std::string owner_;                        // "request `Goto`", for messages
  Name here_;                                // the attribute's word
  std::map<std::string, SourceRange> seen_;  // attributes of this block
  std::string_view type_;
  std::array<Name, 5> codels_;
  Service request_;
  Task task_;
  Poster poster_;
  Name init_;
};

}  // namespace

Module parse_genom2(const std::vector<Token>& tokens, Headers headers, Diagnostics& diags) {
  return Genom2Parser(tokens, headers, diags).run();
}

}  // namespace bip::genom
