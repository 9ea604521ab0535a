// See read_observer.hpp.
#include "compiler/library/read_observer.hpp"

#include <memory>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/property/property.hpp"

namespace bip::library {
namespace {

constexpr std::string_view kForms =
    "an observer is `count NAME`, `reaches EXPR`, `time until EXPR`, `duration of EXPR`, `max EXPR`, `min EXPR`, "
    "`mean EXPR` or `last EXPR`";

struct Form {
  std::string_view words;  // before the expression
  rt::ObserverKind kind;
  bool is_condition;
};
constexpr Form kExpressionForms[] = {{"reaches", rt::ObserverKind::Reaches, true},
                                     {"time until", rt::ObserverKind::Time, true},
                                     {"duration of", rt::ObserverKind::Duration, true},
                                     {"max", rt::ObserverKind::Max, false},
                                     {"min", rt::ObserverKind::Min, false},
                                     {"mean", rt::ObserverKind::Mean, false},
                                     {"last", rt::ObserverKind::Last, false}};

/// What follows the words, if the text begins with them; blanks between words count as one.
std::optional<std::string> after(std::string_view words, std::string_view text) {
  while (true) {
    const std::size_t begin = text.find_first_not_of(" \t");
    text.remove_prefix(std::min(begin, text.size()));
    const std::string_view word = words.substr(0, words.find(' '));
    if (!text.starts_with(word)) return std::nullopt;
    text.remove_prefix(word.size());
    if (!text.empty() && text.front() != ' ' && text.front() != '\t' && text.front() != '(' && text.front() != '!')
      return std::nullopt;
    words.remove_prefix(std::min(word.size() + 1, words.size()));
    if (words.empty()) return std::string(text);
  }
}

Result<rt::Observer> read_count(const std::string& name, const System& system, rt::Observer observer) {
  const auto is_called = [&](const std::string& path) { return path == name || path == "ROOT." + name; };
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    if (!is_called(system.connectors[ConnectorId(row)].path)) continue;
    observer.connector = static_cast<std::uint32_t>(row);
    return observer;
  }
  const std::size_t dot = name.rfind('.');
  for (std::size_t row = 0; dot != std::string::npos && row < system.atoms.size(); ++row) {
    const Atom& atom = system.atoms[AtomId(row)];
    if (atom.path != name.substr(0, dot) && atom.path != "ROOT." + name.substr(0, dot)) continue;
    const std::vector<Port>& ports = system.atom_types[atom.type].ports;
    for (std::size_t port = 0; port < ports.size(); ++port) {
      if (ports[port].name != name.substr(dot + 1)) continue;
      observer.atom = static_cast<std::uint32_t>(row);
      observer.port = static_cast<std::uint32_t>(port);
      return observer;
    }
  }
  return Failure{"there is no connector and no port `" + name + "`"};
}

}  // namespace

Result<rt::Observer> read_observer(const std::string& text, const System& system) {
  rt::Observer observer;
  observer.text = std::string(trimmed(text));
  if (const auto name = after("count", text))
    return read_count(std::string(trimmed(*name)), system, std::move(observer));
  for (const Form& form : kExpressionForms) {
    const std::optional<std::string> rest = after(form.words, text);
    if (!rest) continue;
    const std::string expression_text(trimmed(*rest));
    if (expression_text.empty()) break;
    Result<verify::Property> expression = verify::parse_value(expression_text, system);
    if (!expression) return Failure{"`" + expression_text + "`, " + expression.error()};
    if (form.is_condition && !verify::is_condition(*expression))
      return Failure{"`" + std::string(form.words) + "` takes a condition, and `" + expression_text + "` is a number"};
    observer.kind = form.kind;
    observer.value = [property = std::make_shared<const verify::Property>(std::move(*expression))](
                         const rt::Core& core) { return verify::value_in(*property, core); };
    return observer;
  }
  return Failure{std::string(kForms)};
}

Result<std::function<double(const rt::Core&)>> read_number(const std::string& text, const System& system) {
  Result<verify::Property> expression = verify::parse_value(text, system);
  if (!expression) return Failure{fmt::format("`{}`, {}", trimmed(text), expression.error())};
  return std::function<double(const rt::Core&)>(
      [property = std::make_shared<const verify::Property>(std::move(*expression))](const rt::Core& core) {
        return verify::value_in(*property, core);
      });
}

Result<std::function<bool(const rt::Core&)>> read_condition(const std::string& text, const System& system) {
  Result<verify::Property> expression = verify::parse_value(text, system);
  if (!expression) return Failure{fmt::format("`{}`, {}", trimmed(text), expression.error())};
  if (!verify::is_condition(*expression))
    return Failure{fmt::format("`{}` is a number, not a condition", trimmed(text))};
  return std::function<bool(const rt::Core&)>(
      [property = std::make_shared<const verify::Property>(std::move(*expression))](const rt::Core& core) {
        return verify::value_in(*property, core) != 0;
      });
}

}  // namespace bip::library
