// See build_weight.hpp. Linear in the annotations.
#include "compiler/model/build_weight.hpp"

#include <charconv>
#include <optional>

namespace bip::model {

namespace {

std::optional<double> positive_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !is_weight(value)) return std::nullopt;
  return value;
}

// What stands between the parentheses; empty: not exactly one thing.
std::string_view only_argument(const syntax::Annotation& a) {
  return a.args.size() == 1 && a.args[0].value.empty() ? a.args[0].key.text : std::string_view();
}

std::string_view written(const ModelBuilder& b, const syntax::Annotation& a) {
  return b.model.sources->text(a.range.file).substr(a.range.begin, a.range.end - a.range.begin);
}

bool is_number(const DataVariable& v) { return v.type == Type::Int || v.type == Type::Float; }

}  // namespace

Weight build_weight(ModelBuilder& b, const syntax::Transition& t, const AtomType& atom) {
  Weight out;
  for (const syntax::Annotation& a : t.annotations) {
    if (a.name.text != "weight") continue;
    if (t.internal) b.diags.report(Diag::kB1612, a.range, "a", "@weight");
    const std::string_view argument = only_argument(a);
    if (const std::optional<double> value = positive_number(argument)) {
      out.value = *value;
      continue;
    }
    std::vector<std::string> known;
    for (std::uint32_t k = 0; k < atom.variables.size(); ++k) {
      const DataVariable& v = atom.variables[k];
      if (!v.is_param || !is_number(v)) continue;
      if (v.name == argument) out.param = k;
      known.push_back(v.name);
    }
    if (out.param == Weight::kNone)
      help_similar(b.diags.report(Diag::kB4024, a.range, written(b, a), ", or a parameter that is a number"), argument,
                   a.range, known);
  }
  return out;
}

double build_weight(ModelBuilder& b, const syntax::CompoundItem& connector, bool exports) {
  double out = 1;
  for (const syntax::Annotation& a : connector.annotations) {
    if (a.name.text != "weight") continue;
    if (const std::optional<double> value = positive_number(only_argument(a))) out = *value;
    else b.diags.report(Diag::kB4024, a.range, written(b, a), "");
    if (exports) b.diags.report(Diag::kB4025, a.range, connector.name.text);
  }
  return out;
}

}  // namespace bip::model
