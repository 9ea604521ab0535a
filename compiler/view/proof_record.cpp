// See proof_record.hpp.
#include "compiler/view/proof_record.hpp"
#include "compiler/system/system.hpp"
#include "compiler/view/zone_record.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace bip::view {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    if (end > at) parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

class CertificateReader {
 public:
  explicit CertificateReader(const System& system) : system_(system), zones_(system) {
    for (std::size_t k = 0; k < system.atoms.size(); ++k) atoms_[system.atoms[AtomId(k)].path] = k;
  }

  Result<Json> read(std::string_view text) {
    const std::vector<std::string_view> lines = split(text, '\n');
    if (lines.empty() || lines.front() != "bipc-certificate 1") return fail("it is no certificate of version 1");
    Json out{{"claim", ""}, {"method", ""}, {"left_out", 0}, {"rows", Json::array()}};
    std::size_t left_out = 0;
    for (std::size_t k = 1; k < lines.size(); ++k) {
      const std::size_t end = lines[k].find_first_not_of(' ') == 0 ? lines[k].find(' ') : lines[k].find(' ', 2);
      const std::string_view kind = lines[k].substr(0, end);
      const std::string_view rest = end == std::string_view::npos ? std::string_view() : lines[k].substr(end + 1);
      if (kind == "claim" || (kind == "method" && rest != "words")) out[std::string(kind)] = std::string(rest);
      else if (kind == "bipc-certificate" || rest == "words")
        return fail("it is about all sizes, not about one system");
      else if (kind == "class") begin_class(rest);
      else if (kind == "  mode") add_mode(rest);
      else if (kind == "component") add_component(rest);
      else if (kind == "trap" || kind == "one-token" || kind == "sum" || kind == "equation" || kind == "lemma") {
        Json row = invariant(kind, rest);
        if (!problem_.empty()) return fail(fmt::format("line {}: {}", k + 1, problem_));
        if (out["rows"].size() < kMostInvariants) out["rows"].push_back(std::move(row));
        else ++left_out;
      } else if (has_zones(out) && kind == "pair") {
        for (const std::string_view word : split(rest, ' ')) holders_.insert(word);
      } else if (has_zones(out) && (kind == "state" || kind == "zone")) {
        if (kind == "state") zones_.add_state(without_numbers(split(rest, ' ')));
        else zones_.add_zone(split(rest, ' '));
        if (!zones_.problem().empty()) return fail(fmt::format("line {}: {}", k + 1, zones_.problem()));
      } else if (kind == "state" || kind == "states") ++left_out;
      else if (kind != "root" && kind != "end" && kind != "components")
        return fail(fmt::format("line {}: a row `{}`", k + 1, kind));
      if (!problem_.empty()) return fail(fmt::format("line {}: {}", k + 1, problem_));
    }
    // Domains of components that never get somewhere; the others say nothing.
    for (Json& row : domains_) {
      if (out["rows"].size() < kMostInvariants) out["rows"].push_back(std::move(row));
      else ++left_out;
    }
    out["left_out"] = left_out + zones_.left_out();
    if (has_zones(out)) out["locations"] = zones_.take();
    return out;
  }

 private:
  struct Mode {
    Json places = Json::array(), values = Json::array();
  };
  struct Class {
    std::optional<std::size_t> type;
    std::vector<Mode> modes;
  };

  static Result<Json> fail(const std::string& why) { return Failure{why}; }
  static bool has_zones(const Json& out) { return out["method"] == "zones" || out["method"] == "pairs"; }
  // In states of a pair the number of a third component stands for all others, so the page shows no numbers.
  [[nodiscard]] std::vector<std::string_view> without_numbers(std::vector<std::string_view> words) const {
    std::erase_if(words, [&](std::string_view word) { return holders_.contains(word.substr(0, word.find('='))); });
    return words;
  }

  void begin_class(std::string_view rest) {
    const std::vector<std::string_view> words = split(rest, ' ');
    Class made;
    for (std::size_t k = 0; k < system_.atom_types.size() && words.size() == 2; ++k)
      if (system_.atom_types[AtomTypeId(k)].name == words[1]) made.type = k;
    if (!made.type) problem_ = "an atom type that the model does not have";
    classes_.push_back(std::move(made));
  }

  void add_mode(std::string_view rest) {
    if (classes_.empty() || !classes_.back().type) return;
    Mode mode;
    const AtomType& type = system_.atom_types[AtomTypeId(*classes_.back().type)];
    for (const std::string_view word : split(rest, ' ')) {
      if (word.front() == '@') mode.places.push_back(std::string(word.substr(1)));
      if (word.front() != '.') continue;
      const std::size_t sign = word.find('=');
      if (const auto row = variable_of(type, word.substr(1, sign - 1)); row && sign != std::string_view::npos)
        mode.values.push_back({*row, std::string(word.substr(sign + 1))});
    }
    classes_.back().modes.push_back(std::move(mode));
  }

  void add_component(std::string_view rest) {
    // "ROOT.fork[0] class 0 reachable 0 1"
    const std::vector<std::string_view> words = split(rest, ' ');
    if (words.size() < 4) return;
    const auto atom = atoms_.find(std::string(words[0]));
    if (atom == atoms_.end()) return no_component(words[0]);
    const std::size_t row = number(words[2]);
    if (row >= classes_.size()) return void(problem_ = "a class that is none");
    class_of_[atom->second] = row;
    const Class& of = classes_[row];
    if (words.size() - 4 == of.modes.size()) return;
    Json terms = Json::array();
    for (std::size_t k = 4; k < words.size(); ++k)
      if (const std::size_t mode = number(words[k]); mode < of.modes.size())
        terms.push_back({1, Json::array({{atom->second, of.modes[mode].places, of.modes[mode].values, false}})});
    domains_.push_back({"domain", 1, std::move(terms)});
  }

  void no_component(std::string_view path) {
    problem_ = fmt::format("the model has no component `{}`", path.starts_with("ROOT.") ? path.substr(5) : path);
  }

  static std::size_t number(std::string_view text) {
    std::size_t value = 0;
    for (const char c : text) {
      if (c < '0' || c > '9' || value > 1'000'000'000) return ~std::size_t{0};
      value = value * 10 + static_cast<std::size_t>(c - '0');
    }
    return text.empty() ? ~std::size_t{0} : value;
  }

  static std::optional<std::size_t> variable_of(const AtomType& type, std::string_view name) {
    for (std::size_t k = 0; k < type.visible_variables(); ++k)
      if (type.variables[k].name == name) return k;
    return std::nullopt;
  }

  Json invariant(std::string_view kind, std::string_view rest) {
    std::vector<std::string_view> words = split(rest, ' ');
    std::string total = "1";
    if ((kind == "sum" || kind == "equation") && !words.empty()) {
      total = std::string(words.front());
      words.erase(words.begin());
    }
    Json terms = Json::array();
    for (std::string_view word : words) {
      std::string weight = "1";
      if (kind == "sum" || kind == "equation") {
        const std::size_t star = word.rfind('*');
        if (star == std::string_view::npos) continue;
        weight = std::string(word.substr(star + 1));
        word = word.substr(0, star);
      }
      Json literals = Json::array();
      for (const std::string_view part : split(word, '&')) literals.push_back(literal(part));
      terms.push_back({weight, std::move(literals)});
    }
    return {std::string(kind), total, std::move(terms)};
  }

  // `PATH:MODE`, `PATH@PLACE`, `PATH.VARIABLE=…`, `PATH.VARIABLE:BIT`, `PATH.VARIABLE`; `!` before it.
  Json literal(std::string_view word) {
    const bool is_negated = word.starts_with('!');
    if (is_negated) word.remove_prefix(1);
    if (const std::size_t at = word.find('@'); at != std::string_view::npos) {
      const auto atom = atoms_.find(std::string(word.substr(0, at)));
      if (atom == atoms_.end()) return no_component(word.substr(0, at)), nullptr;
      return {atom->second, Json::array({std::string(word.substr(at + 1))}), Json::array(), is_negated};
    }
    const std::size_t colon = word.rfind(':');
    if (colon != std::string_view::npos && word.find('=') == std::string_view::npos) {
      const auto atom = atoms_.find(std::string(word.substr(0, colon)));
      const auto of = atom == atoms_.end() ? class_of_.end() : class_of_.find(atom->second);
      const std::size_t mode = number(word.substr(colon + 1));
      if (of != class_of_.end() && mode < classes_[of->second].modes.size()) {
        const Mode& found = classes_[of->second].modes[mode];
        return {atom->second, found.places, found.values, is_negated};
      }
    }
    const std::size_t sign = std::min(word.find('='), colon);
    const std::string_view path = word.substr(0, sign);
    const std::size_t dot = path.rfind('.');
    const auto atom = atoms_.find(std::string(path.substr(0, dot)));
    if (dot == std::string_view::npos || atom == atoms_.end()) return no_component(path), nullptr;
    const auto row = variable_of(system_.atom_types[system_.atoms[AtomId(atom->second)].type], path.substr(dot + 1));
    if (!row) return void(problem_ = fmt::format("no variable `{}`", path)), nullptr;
    Json value(nullptr);
    if (sign < word.size()) value = std::string(word.substr(word[sign] == '=' ? sign + 1 : sign));
    return {atom->second, nullptr, Json::array({{*row, value}}), is_negated};
  }

  const System& system_;
  std::map<std::string, std::size_t> atoms_;
  std::vector<Class> classes_;
  std::map<std::size_t, std::size_t> class_of_;
  std::vector<Json> domains_;
  ZoneRecorder zones_;
  std::set<std::string_view> holders_;  // data of a pair, in the text
  std::string problem_;
};

}  // namespace

Result<Json> record_proof(const System& system, std::string_view certificate) {
  return CertificateReader(system).read(certificate);
}

}  // namespace bip::view
