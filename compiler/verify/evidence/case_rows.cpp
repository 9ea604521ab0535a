// See case_rows.hpp.
#include "compiler/verify/evidence/case_rows.hpp"

#include <algorithm>
#include <limits>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

std::vector<CaseColumn> place_columns(const AtomType& type) {
  if (type.is_automaton()) return {{CaseColumn::About::Automaton, 0, false}};
  std::vector<CaseColumn> columns;
  for (std::uint32_t place = 0; place < type.places.size(); ++place)
    columns.push_back({CaseColumn::About::Place, place, false});
  return columns;
}

bool is_nameable(const DataVariable& variable) {
  return !variable.is_param && variable.name.find(' ') == std::string::npos;
}

std::vector<ValueBox> joined_boxes(std::vector<ValueBox> boxes, const std::vector<CaseColumn>& columns) {
  std::sort(boxes.begin(), boxes.end());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (!columns[k].is_int) continue;
    std::sort(boxes.begin(), boxes.end(), [&](const ValueBox& a, const ValueBox& b) {
      const auto rest = [&](const ValueBox& box) {
        ValueBox others = box;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
        return others;
      };
      const ValueBox of_a = rest(a), of_b = rest(b);
      return of_a != of_b ? of_a < of_b : a[k] < b[k];
    });
    std::vector<ValueBox> fewer;
    for (ValueBox& box : boxes) {
      if (!fewer.empty()) {
        ValueBox longer = fewer.back();
        const bool follows = std::int64_t{longer[k].high} + 1 == box[k].low;
        longer[k] = box[k];
        if (follows && longer == box) {
          fewer.back()[k].high = box[k].high;
          continue;
        }
      }
      fewer.push_back(std::move(box));
    }
    boxes = std::move(fewer);
  }
  return boxes;
}

std::string case_text(const Atom& atom, const AtomType& type, const std::vector<CaseColumn>& columns,
                      const ValueBox& box) {
  BIP_ASSERT(box.size() == columns.size(), "{} values of {} columns", box.size(), columns.size());
  constexpr ValueRange kAny{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
  std::string out;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k].is_int && box[k] == kAny) continue;
    if (!out.empty()) out += '&';
    switch (columns[k].about) {
      case CaseColumn::About::Automaton:
        out += atom.path + '@' + type.places[static_cast<std::size_t>(box[k].low)];
        break;
      case CaseColumn::About::Place:
        out += (box[k].low == 0 ? "!" : "") + atom.path + '@' + type.places[columns[k].row];
        break;
      case CaseColumn::About::Value:
        out += atom.path + '.' + type.variables[columns[k].row].name + '=' + std::to_string(box[k].low);
        if (box[k].low != box[k].high) out += ".." + std::to_string(box[k].high);
        break;
    }
  }
  return out;
}

}  // namespace bip::verify
