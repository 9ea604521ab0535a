// Folded tables of instances: rows that arrays of components or connectors repeat are stored once (rt::Rows).
//
// Folding is the last pass over a table. Decoded rows equal the original ones, including names and places; irregular
// rows are stored as they are. Small tables are not folded, because people read them in emitted files. Linear, except
// for the search of a period, which tries the first 64. Names are copied, so the System's names are not needed
// afterwards.
#pragma once
#include <vector>

#include "compiler/base/arena.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::lower {

template <class T>
struct Table {
  std::vector<T> rows;  // all; once folded, those that stand
  std::vector<rt::Repeat> repeats;
  std::vector<typename T::Slope> slopes;
  std::uint32_t size = 0;

  [[nodiscard]] rt::Rows<T> view() const {
    const auto span = [](const auto& items) {
      return rt::Span<std::remove_cvref_t<decltype(items[0])>>{items.data(), static_cast<std::uint32_t>(items.size())};
    };
    return {span(rows), span(repeats), span(slopes), size};
  }
};

inline constexpr std::size_t kFewRows = 256;

void fold(Table<rt::Atom>& table, Arena& arena);
void fold(Table<rt::Connector>& table, Arena& arena);
void fold(Table<rt::PortRef>& table, Arena& arena);
void fold(Table<rt::Bind>& table, Arena& arena);

}  // namespace bip::lower
