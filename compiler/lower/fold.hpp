// Tables of instances, folded: what an array of components or connectors repeats stands once (rt::Rows).
//
// Folding is the last thing that happens to a table. Rows, names and places included, come out as they went in; what
// does not repeat stands as it is. Tables of a screenful are left alone: whoever reads an emitted file wants to see
// them. Linear but for the search of a period, which tries the first 64; names are copied, so the System's are no
// longer needed.
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
