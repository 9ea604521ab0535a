// See suggest_property.hpp. The text is rewritten in three passes (the temporal operator, the signs, the names); the
// result is suggested only if it can be read.
#include "compiler/library/suggest_property.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/base/ascii.hpp"
#include "compiler/diag/diagnostics.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/property/quantifier.hpp"

namespace bip::library {
namespace {

/// How UPPAAL, CTL and LTL begin a property.
struct Prefix {
  std::string_view other, word;
};
constexpr Prefix kPrefixes[] = {
    {"A[]", "always"},     {"AG", "always"},     {"[]", "always"},           {"G", "always"},
    {"E<>", "possibly"},   {"EF", "possibly"},   {"E[]", "possibly always"}, {"EG", "possibly always"},
    {"A<>", "eventually"}, {"AF", "eventually"}, {"<>", "eventually"},       {"F", "eventually"}};
constexpr std::string_view kWords[] = {"never",    "always", "can",    "happens",    "eventually",   "next",
                                       "implies",  "until",  "unless", "leads",      "to",           "true",
                                       "false",    "since",  "once",   "previously", "historically", "within",
                                       "possibly", "under",  "weak",   "strong",     "atoms"};

bool is_name_char(char c) { return is_letter(c) || is_digit(c) || c == '_'; }

/// `deadlok`, `deadlock-free`, `A[] not deadlock`, `error`; empty if the text speaks of something else.
std::string meant_question(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (is_letter(c)) {
      words.back() += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  std::string meant;
  for (const std::string& word : words) {
    constexpr std::string_view kFillers[] = {"",    "a",  "ag",    "g",      "e",    "ef",
                                             "not", "no", "never", "always", "free", "freedom"};
    if (std::find(std::begin(kFillers), std::end(kFillers), word) != std::end(kFillers)) continue;
    const std::vector<std::string> similar =
        similar_names(word, {"deadlock", "deadlocks", "deadlockfree", "errors", "error"});
    std::string question = word;
    if (!similar.empty()) question = similar.front();
    if (question.starts_with("deadlock")) question = "deadlock";
    if (question == "error") question = "errors";
    if ((question != "deadlock" && question != "errors") || !meant.empty()) return {};
    meant = question;
  }
  return meant;
}

/// Replaces signs and words of other languages outside of strings.
std::string with_our_signs(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kOperators = {
      {{"and", "&&"}, {"or", "||"}, {"not", "!"}}};
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '"') {
      const std::size_t end = std::min(text.find('"', i + 1), text.size() - 1);
      out += text.substr(i, end - i + 1);
      i = end + 1;
      continue;
    }
    if (is_letter(text[i]) || text[i] == '_') {
      std::size_t end = i;
      while (end < text.size() && is_name_char(text[end])) ++end;
      std::string_view word = text.substr(i, end - i);
      const bool is_part = !out.empty() && (out.back() == '.' || out.back() == '@');
      for (const auto& [other, sign] : kOperators) {
        if (word != other || is_part) continue;
        word = sign;
        // `not x` is `!x`.
        while (other == "not" && end < text.size() && text[end] == ' ') ++end;
      }
      out += word;
      i = end;
      continue;
    }
    if (text.substr(i, 2) == "<>") {
      out += "!=";
      i += 2;
      continue;
    }
    const bool is_pair =
        i > 0 && (text[i - 1] == '=' || text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!');
    const bool is_single = text[i] == '=' && !is_pair && text.substr(i, 2) != "==" && text.substr(i, 2) != "=>";
    out += text[i++];
    if (is_single) out += '=';
  }
  return out;
}

bool has_quantifier(std::string_view text) {
  return std::any_of(std::begin(verify::kQuantifiers), std::end(verify::kQuantifiers),
                     [&](const verify::QuantifierWord& quantifier) {
                       return text.find(std::string(quantifier.word) + ' ') != std::string_view::npos;
                     });
}

/// Are they the same but for small and capital letters?
bool is_same_word(std::string_view a, std::string_view b) {
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return small(x) == small(y); });
}

/// A name alone: that of a property that the model states, with a slip or without its compound.
std::optional<PropertySuggestion> suggest_stated(std::string_view text, const System& system) {
  const bool is_name = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return is_name_char(c) || c == '.' || c == '[' || c == ']';
  });
  const bool is_word = std::find(std::begin(kWords), std::end(kWords), text) != std::end(kWords);
  if (!is_name || is_word || system.properties.empty()) return std::nullopt;
  constexpr std::size_t kShown = 4;
  std::vector<std::string> names;
  std::string ending, shown;
  for (const StatedProperty& stated : system.properties) {
    names.push_back(stated.name);
    if (ending.empty() && stated.name.ends_with('.' + std::string(text))) ending = stated.name;
    if (names.size() <= kShown) shown += (shown.empty() ? "`" : ", `") + stated.name + "`";
  }
  if (names.size() > kShown) shown += ", …";
  const std::vector<std::string> similar = similar_names(text, names);
  return PropertySuggestion{"the model states the properties " + shown, !ending.empty()    ? ending
                                                                        : !similar.empty() ? similar.front()
                                                                                           : ""};
}

/// Gives each name that is not of the system the likeliest one that is.
class NameMender {
 public:
  NameMender(std::string text, const System& system) : text_(std::move(text)), system_(system) {}

  std::string run() {
    std::string out, before;
    for (at_ = 0; at_ < text_.size();) {
      if (text_[at_] == '"') {
        const std::size_t end = std::min(text_.find('"', at_ + 1), text_.size() - 1);
        out += text_.substr(at_, end - at_ + 1);
        at_ = end + 1;
      } else if (is_letter(text_[at_]) || text_[at_] == '_') {
        const std::string path = read_path();
        const bool is_word = std::find(std::begin(kWords), std::end(kWords), path) != std::end(kWords);
        out += is_word                                  ? path
               : is_text(path, out)                     ? '"' + path + '"'
               : before == "can" || before == "happens" ? offer(path)
               : before == "weak" || before == "strong" ? fair(path)
                                                        : reference(path);
        before = path;
      } else {
        // 1e3 is a number.
        const bool is_number = is_digit(text_[at_]);
        do out += text_[at_++];
        while (is_number && at_ < text_.size() && (is_name_char(text_[at_]) || text_[at_] == '.'));
      }
    }
    return out;
  }
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  using Paths = std::vector<std::string>;

  std::string read_path() {
    const std::size_t first = at_;
    for (;;) {
      while (at_ < text_.size() && is_name_char(text_[at_])) ++at_;
      while (at_ < text_.size() && text_[at_] == '[') {
        const std::size_t end = text_.find(']', at_);
        if (end == std::string_view::npos) break;
        at_ = end + 1;
      }
      if (at_ + 1 >= text_.size() || text_[at_] != '.' || !is_letter(text_[at_ + 1])) break;
      ++at_;
    }
    return text_.substr(first, at_ - first);
  }

  template <class Rows>
  static Paths paths_of(const Rows& rows) {
    Paths paths;
    for (const auto& row : rows) paths.push_back(row.path.substr(std::string_view("ROOT.").size()));
    return paths;
  }
  static std::string without_indices(std::string_view path) {
    std::string out;
    bool is_inside = false;
    for (const char c : path) {
      is_inside = is_inside || c == '[';
      if (!is_inside) out += c;
      is_inside = is_inside && c != ']';
    }
    return out;
  }

  /// The path that a wrong one stands for: the end of one, one with another index, a similar one; empty if none.
  std::string meant(const std::string& path, const Paths& paths, const char* what) {
    enum class Indices : std::uint8_t { Kept, Dropped };
    const auto ends_so = [&](std::string_view end, Indices indices) {
      Paths found;
      for (const std::string& known : paths) {
        const std::string shown = indices == Indices::Kept ? known : without_indices(known);
        if (shown == end ||
            (shown.size() > end.size() && shown.ends_with(end) && shown[shown.size() - end.size() - 1] == '.'))
          found.push_back(known);
      }
      return found;
    };
    Paths found = ends_so(path, Indices::Kept);
    if (found.empty()) found = ends_so(without_indices(path), Indices::Dropped);
    if (found.empty()) {
      found = similar_names(path, paths);
      if (found.empty()) return {};
      found.resize(1);
    }
    if (found.size() > 1)
      note_ = "the " + std::string(what) + " here are `" + found.front() + "` to `" + found.back() + "`";
    return found.front();
  }

  [[nodiscard]] const AtomType* find_type(const std::string& atom_path) const {
    for (const Atom& atom : system_.atoms) {
      if (atom.path == "ROOT." + atom_path) return &system_.atom_types[atom.type];
    }
    return nullptr;
  }
  /// The component, or one of the type that is named so.
  std::string component(const std::string& path) {
    if (find_type(path) != nullptr) return path;
    Paths of_type;
    for (const Atom& atom : system_.atoms) {
      if (system_.atom_types[atom.type].name == path) of_type.push_back(atom.path.substr(5));
    }
    if (!of_type.empty()) {
      note_ = "`" + path + "` is a type; its components are `" + of_type.front() + "`";
      if (of_type.size() > 1) note_ += " to `" + of_type.back() + "`";
      return of_type.front();
    }
    const std::string found = meant(path, paths_of(system_.atoms), "components");
    return found.empty() ? path : found;
  }
  static std::string similar_or(const std::string& name, const Paths& known) {
    if (std::find(known.begin(), known.end(), name) != known.end()) return name;
    for (const std::string& other : known) {
      if (is_same_word(name, other)) return other;
    }
    const std::vector<std::string> similar = similar_names(name, known);
    return similar.empty() ? name : similar.front();
  }

  std::string reference(const std::string& path) {
    if (at_ < text_.size() && text_[at_] == '@') {
      const std::string atom = component(path);
      ++at_;
      const std::string place = read_path();
      const AtomType* type = find_type(atom);
      return atom + "@" + (type == nullptr ? place : similar_or(place, type->places));
    }
    if (const AtomType* whole = find_type(path)) {
      describe(path, *whole);
      return path;
    }
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return path;
    const std::string atom = component(path.substr(0, dot)), last = path.substr(dot + 1);
    const AtomType* type = find_type(atom);
    if (type == nullptr) return path;
    if (std::find(type->places.begin(), type->places.end(), last) != type->places.end()) return atom + "@" + last;
    Paths variables;
    for (const auto& variable : type->variables) variables.push_back(variable.name);
    return atom + "." + similar_or(last, variables);
  }

  [[nodiscard]] bool is_string(std::string_view path) const {
    const std::size_t dot = path.rfind('.');
    const AtomType* type = dot == std::string_view::npos ? nullptr : find_type(std::string(path.substr(0, dot)));
    return type != nullptr && std::any_of(type->variables.begin(), type->variables.end(), [&](const auto& variable) {
             return variable.name == path.substr(dot + 1) && variable.type == Type::String;
           });
  }
  /// Is a word, which ends here, compared with a string? `before`: what stands before it.
  bool is_text(const std::string& word, std::string_view before) {
    if (!std::all_of(word.begin(), word.end(), is_name_char) || (at_ < text_.size() && text_[at_] == '@')) return false;
    before = trimmed(before);
    if (before.ends_with("==") || before.ends_with("!=")) {
      before = trimmed(before.substr(0, before.size() - 2));
      std::size_t start = before.size();
      while (start > 0 && (is_name_char(before[start - 1]) ||
                           std::string_view(".[]").find(before[start - 1]) != std::string_view::npos))
        --start;
      return is_string(before.substr(start));
    }
    const std::size_t word_end = at_;
    const auto skip_blanks = [&] {
      while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    };
    skip_blanks();
    const bool is_compared = text_.compare(at_, 2, "==") == 0 || text_.compare(at_, 2, "!=") == 0;
    at_ = std::min(at_ + 2, text_.size());
    skip_blanks();
    const bool is_before_string = is_compared && is_string(read_path());
    at_ = word_end;
    return is_before_string;
  }

  void describe(const std::string& path, const AtomType& type) {
    constexpr std::size_t kShown = 4;
    std::string text;
    for (std::size_t k = 0; k < std::min(type.places.size(), kShown); ++k)
      text += (text.empty() ? "`" : ", `") + path + "@" + type.places[k] + "`";
    for (std::size_t k = 0; k < std::min(type.variables.size(), kShown); ++k)
      text += ", `" + path + "." + type.variables[k].name + "`";
    note_ = "a component is at a place or has data: " + text;
  }

  std::string offer(const std::string& path) {
    const Paths connectors = paths_of(system_.connectors);
    if (std::find(connectors.begin(), connectors.end(), path) != connectors.end()) return path;
    const std::size_t dot = path.rfind('.');
    if (dot != std::string::npos) {
      const std::string atom = path.substr(0, dot);
      if (const AtomType* type = find_type(atom)) {
        Paths ports;
        for (const auto& port : type->ports) ports.push_back(port.name);
        return atom + "." + similar_or(path.substr(dot + 1), ports);
      }
    }
    const std::string found = meant(path, connectors, "connectors");
    return found.empty() ? path : found;
  }

  /// What fairness speaks of: also a component.
  std::string fair(const std::string& path) {
    if (find_type(path) != nullptr) return path;
    const std::string offered = offer(path);
    return offered == path ? component(path) : offered;
  }

  std::string text_;
  const System& system_;
  std::size_t at_ = 0;
  std::string note_;
};

}  // namespace

std::optional<PropertySuggestion> suggest_property(const std::string& text, const System& system) {
  const std::string_view whole = trimmed(text);
  if (const std::string question = meant_question(whole); !question.empty()) return PropertySuggestion{"", question};
  if (std::optional<PropertySuggestion> stated = suggest_stated(whole, system)) return stated;
  // Of a property of states, without what only runs have.
  if (const std::size_t under = whole.rfind(" under "); under != std::string_view::npos) {
    const std::string before(whole.substr(0, under));
    Result<verify::Question> read = read_question(before, system);
    const bool is_of_states =
        read && (read->what == verify::QuestionKind::State ||
                 (read->what == verify::QuestionKind::Runs && verify::is_invariant_of_past(read->formula)));
    if (is_of_states) return PropertySuggestion{"", before};
  }
  PropertySuggestion suggestion;
  std::string_view rest = whole;
  std::string word;
  for (const Prefix& prefix : kPrefixes) {
    if (!word.empty() || !whole.starts_with(prefix.other)) continue;
    const bool ends = is_letter(prefix.other.back()) && whole.size() > prefix.other.size() &&
                      is_name_char(whole[prefix.other.size()]);
    if (ends) continue;
    rest = trimmed(whole.substr(prefix.other.size()));
    word = prefix.word;
  }
  if (word.empty()) {
    std::size_t end = 0;
    while (end < whole.size() && is_letter(whole[end])) ++end;
    const bool is_word = end < whole.size() && (whole[end] == ' ' || whole[end] == '(');
    const std::vector<std::string> similar =
        similar_names(whole.substr(0, end), {"never", "always", "eventually", "possibly"});
    if (is_word && !similar.empty()) {
      word = similar.front();
      rest = trimmed(whole.substr(end));
    }
  }
  NameMender names(with_our_signs(rest), system);
  // Variables of quantifiers are no misspelt names.
  const std::string mended = has_quantifier(rest) ? with_our_signs(rest) : names.run();
  if (!names.note().empty()) suggestion.note = names.note();
  // A condition alone: bad states are asked for more often than good ones.
  const std::vector<std::string> tries = word.empty() ? std::vector<std::string>{mended, "never " + mended}
                                                      : std::vector<std::string>{word + " " + mended};
  for (const std::string& candidate : tries) {
    if (candidate == text || !read_question(candidate, system)) continue;
    suggestion.property = candidate;
    if (word.empty() && &candidate == &tries.back() && suggestion.note.empty())
      suggestion.note = "`never` is for conditions that must not hold, `always` for those that must";
    return suggestion;
  }
  if (suggestion.note.empty()) return std::nullopt;
  return suggestion;
}

std::optional<PropertySuggestion> suggest_fairness(const std::string& text, const System& system) {
  NameMender names(text, system);
  const std::string mended = names.run();
  if (mended == text || !verify::read_fairness(mended, system)) return std::nullopt;
  return PropertySuggestion{names.note(), mended};
}

}  // namespace bip::library
