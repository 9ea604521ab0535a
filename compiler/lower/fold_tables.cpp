// Folds tables, see fold_tables.hpp. A range of rows is a series if, from period to period, each number grows by the
// same difference, and one index in each name by one.
#include "compiler/lower/fold_tables.hpp"
#include "compiler/base/ascii.hpp"
#include "runtime/include/bip/assert.hpp"

#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

namespace bip::lower {

namespace {

using u32 = std::uint32_t;
constexpr u32 kMostPeriod = 64;
constexpr u32 kLeastTimes = 8;  // fewer are not worth a row of Repeat
// A table is folded if that saves one byte of so many: to read a row of a folded table is a search, else a load.
constexpr u32 kLeastSaved = 4;

bool is_same(const rt::SourceLine& a, const rt::SourceLine& b) {
  return a.file == b.file && a.line == b.line && a.column == b.column;
}
bool is_same(const rt::Atom& a, const rt::Atom& b) {
  return a.type == b.type && a.first_cell == b.first_cell && a.args == b.args && is_same(a.loc, b.loc);
}
bool is_same(const rt::Connector& a, const rt::Connector& b) {
  return a.type == b.type && a.first_cell == b.first_cell && a.ports == b.ports && a.binds == b.binds &&
         a.bind_count == b.bind_count && a.bound == b.bound && a.parent == b.parent && is_same(a.loc, b.loc);
}
bool is_same(const rt::PortRef& a, const rt::PortRef& b) {
  return a.atom == b.atom && a.port == b.port && a.connector == b.connector && a.maximal_only == b.maximal_only &&
         a.choice == b.choice;
}
bool is_same(const rt::Bind& a, const rt::Bind& b) { return a.cell == b.cell; }

rt::Atom::Slope slope(const rt::Atom& a, const rt::Atom& b) { return {b.first_cell - a.first_cell, b.args - a.args}; }
rt::Connector::Slope slope(const rt::Connector& a, const rt::Connector& b) {
  return {b.first_cell - a.first_cell, b.ports - a.ports, b.binds - a.binds, b.parent - a.parent};
}
rt::PortRef::Slope slope(const rt::PortRef& a, const rt::PortRef& b) {
  return {b.atom - a.atom, b.connector - a.connector, b.choice - a.choice};
}
rt::Bind::Slope slope(const rt::Bind& a, const rt::Bind& b) { return {b.cell - a.cell}; }

// A name as text around an index.
struct IndexedName {
  std::string_view before, after;
  u32 index = 0;
  [[nodiscard]] bool is(std::string_view name, u32 times) const {
    char digits[16];
    const std::string_view number(
        digits, static_cast<std::size_t>(std::to_chars(digits, digits + sizeof digits, index + times).ptr - digits));
    return name.size() == before.size() + number.size() + after.size() && name.starts_with(before) &&
           name.substr(before.size()).starts_with(number) && name.ends_with(after);
  }
};

// Of two names that differ in one index, which is one more in the second.
std::optional<IndexedName> indexed(std::string_view a, std::string_view b) {
  std::size_t at = 0;
  while (at < a.size() && at < b.size() && a[at] == b[at]) ++at;
  while (at > 0 && is_digit(a[at - 1])) --at;
  if (at == 0 || a[at - 1] != '[' || a.find('#') != std::string_view::npos) return std::nullopt;
  IndexedName name{.before = a.substr(0, at), .after = {}};
  const auto [end, error] = std::from_chars(a.data() + at, a.data() + a.size(), name.index);
  if (error != std::errc() || name.index > INT32_MAX) return std::nullopt;
  name.after = a.substr(static_cast<std::size_t>(end - a.data()));
  if (!name.is(a, 0) || !name.is(b, 1)) return std::nullopt;
  return name;
}

const char* kept(std::string_view text, Arena& arena) {
  std::string with_end(text);
  with_end += '\0';
  return arena.text(with_end).data();
}

template <class T>
constexpr bool kHasName = requires(const T& row) {
  row.name;
};

template <class T>
class Folder {
 public:
  Folder(Table<T>& table, Arena& arena) : table_(table), arena_(arena), all_(std::exchange(table.rows, {})) {}

  void fold() {
    const u32 size = table_.size = static_cast<u32>(all_.size());
    for (u32 row = 0; row < size;) {
      const u32 period = size < kFewRows ? 0 : find_period(row);
      if (period == 0) stand(row++);
      else row += repeat(row, period);
    }
    BIP_ASSERT(is_as_before(), "{} rows are told by {}", all_.size(), table_.rows.size());
    if (is_hardly_smaller()) unfold();
    table_.rows.shrink_to_fit();
  }

 private:
  [[nodiscard]] bool is_hardly_smaller() const {
    const std::size_t before = all_.size() * sizeof(T);
    return table_.rows.size() * sizeof(T) + table_.repeats.size() * sizeof(rt::Repeat) +
               table_.slopes.size() * sizeof(typename T::Slope) >=
           before - before / kLeastSaved;
  }
  // Does the folded table say what the rows said? For assertions.
  [[nodiscard]] bool is_as_before() const {
    const auto view = table_.view();
    for (u32 row = 0; row < view.size; ++row) {
      if (!is_same(view[row], all_[row])) return false;
      if constexpr (kHasName<T>) {
        if (view[row].path() != all_[row].name) return false;
      }
    }
    return view.size == all_.size();
  }
  // Are times - 1 further rows, a period from each other, as the first two say?
  bool holds(u32 row, u32 period, u32 first, u32 times) const {
    BIP_ASSERT(std::size_t{row} + std::size_t{times - 1} * period < all_.size(), "row {} and {} further ones, of {}",
               row, times, all_.size());
    const T& base = all_[row];
    const T& next = all_[row + period];
    const auto by = slope(base, next);
    std::optional<IndexedName> name;
    if constexpr (kHasName<T>) {
      if (base.type != next.type) return false;
      name = indexed(base.name, next.name);
      if (!name) return false;
    }
    for (u32 k = first; k < times; ++k) {
      const T& there = all_[row + k * period];
      if (!is_same(base.after(by, k), there)) return false;
      if constexpr (kHasName<T>) {
        if (!name->is(there.name, k)) return false;
      }
    }
    return true;
  }
  bool all_hold(u32 row, u32 period, u32 first, u32 times) const {
    for (u32 which = 0; which < period; ++which) {
      if (!holds(row + which, period, first, times)) return false;
    }
    return true;
  }
  u32 find_period(u32 row) const {
    for (u32 period = 1; period <= kMostPeriod && std::size_t{row} + period * kLeastTimes <= all_.size(); ++period) {
      if (all_hold(row, period, 1, kLeastTimes)) return period;
    }
    return 0;
  }
  // How many rows it tells.
  u32 repeat(u32 row, u32 period) {
    u32 times = kLeastTimes;
    while (std::size_t{row} + (times + 1) * std::size_t{period} <= all_.size() &&
           all_hold(row, period, times, times + 1))
      ++times;
    table_.repeats.push_back(
        {row, period, static_cast<u32>(table_.rows.size()), static_cast<u32>(table_.slopes.size())});
    for (u32 which = row; which < row + period; ++which) {
      T first = all_[which];
      table_.slopes.push_back(slope(first, all_[which + period]));
      BIP_ASSERT(table_.slopes.size() <= table_.rows.size() + 1, "{} slopes of {} rows", table_.slopes.size(),
                 table_.rows.size());
      if constexpr (kHasName<T>) {
        const IndexedName name = *indexed(first.name, all_[which + period].name);
        first.name = kept(std::string(name.before) + '#' + std::string(name.after), arena_);
        first.index = name.index;
      }
      table_.rows.push_back(first);
    }
    return times * period;
  }
  void stand(u32 row) {
    const auto at = static_cast<u32>(table_.rows.size());
    if (table_.repeats.empty() || table_.repeats.back().slope != rt::kNone)
      table_.repeats.push_back({row, 0, at, rt::kNone});
    ++table_.repeats.back().period;
    table_.rows.push_back(with_kept_name(all_[row]));
  }
  // All rows stand.
  void unfold() {
    table_.repeats.clear();
    table_.slopes.clear();
    table_.rows.clear();
    for (const T& row : all_) table_.rows.push_back(with_kept_name(row));
  }
  T with_kept_name(T row) {
    if constexpr (kHasName<T>) row.name = kept(row.name, arena_);
    return row;
  }

  Table<T>& table_;
  Arena& arena_;
  const std::vector<T> all_;
};

}  // namespace

void fold(Table<rt::Atom>& table, Arena& arena) { Folder(table, arena).fold(); }
void fold(Table<rt::Connector>& table, Arena& arena) { Folder(table, arena).fold(); }
void fold(Table<rt::PortRef>& table, Arena& arena) { Folder(table, arena).fold(); }
void fold(Table<rt::Bind>& table, Arena& arena) { Folder(table, arena).fold(); }

}  // namespace bip::lower
