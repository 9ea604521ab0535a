// The paths of a system's components and connectors, listed once for many properties. Internal to
// compiler/verify/property.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "compiler/system/system.hpp"

namespace bip::verify {

using RowsByPath = std::unordered_map<std::string_view, std::uint32_t>;
struct RowsOfPaths {
  explicit RowsOfPaths(const System& system)
      : atoms(rows_by_path(system.atoms)), connectors(rows_by_path(system.connectors)) {}
  template <class Rows>
  static RowsByPath rows_by_path(const Rows& rows) {
    RowsByPath found;
    std::uint32_t row = 0;
    for (const auto& row_of_path : rows) found.try_emplace(row_of_path.path, row++);
    return found;
  }
  // How many positions an array of components has; 0: there is none of this path.
  [[nodiscard]] std::uint32_t size_of_array(const std::string& path) const {
    if (sizes_.empty()) {
      for (const auto& [atom, row] : atoms) {
        for (std::size_t open = atom.find('['); open != std::string_view::npos; open = atom.find('[', open + 1)) {
          std::uint32_t index = 0;
          std::from_chars(atom.data() + open + 1, atom.data() + atom.size(), index);
          std::uint32_t& size = sizes_[atom.substr(0, open)];
          size = std::max(size, index + 1);
        }
      }
    }
    const auto found = sizes_.find(path);
    return found == sizes_.end() ? 0 : found->second;
  }
  RowsByPath atoms, connectors;

 private:
  mutable RowsByPath sizes_;  // by path of an array; made when first asked
};

}  // namespace bip::verify
