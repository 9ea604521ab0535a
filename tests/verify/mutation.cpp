// See mutation.hpp. Rows are lists of words; a change picks a row that it can be made in.
#include "tests/verify/mutation.hpp"

#include <algorithm>
#include <functional>
#include <sstream>
#include <vector>

namespace bip::verify::test {

namespace {

using Row = std::vector<std::string>;
using Rows = std::vector<Row>;

bool is_set(const Row& row) { return row[0] == "trap" || row[0] == "one-token"; }
bool is_clause(const Row& row) { return is_set(row) || row[0] == "lemma" || row[0] == "equation"; }
bool is_component(const Row& row) { return row[0] == "component"; }
bool is_mode(const Row& row) { return row[0] == "mode"; }
// Where the words begin that may come and go.
std::size_t first_word(const Row& row) { return is_component(row) ? 5 : is_mode(row) ? 2 : 1; }

// A row for which `fits`; null: there is none.
Row* pick(Rows& rows, gen::Prng& random, const std::function<bool(const Row&)>& fits) {
  std::vector<Row*> found;
  for (Row& row : rows) {
    if (fits(row)) found.push_back(&row);
  }
  return found.empty() ? nullptr : random.pick(found);
}

// The number at the end of a word, another one.
void change_number(std::string& word, gen::Prng& random) {
  const std::size_t end = word.find_last_not_of("0123456789");
  const std::size_t begin = end == std::string::npos ? 0 : end + 1;
  if (begin == word.size() || word.size() - begin > 8) return;
  const int number = std::stoi(word.substr(begin));
  const int other = random.percent(50)   ? number + 1
                    : random.percent(50) ? number - 1
                                         : static_cast<int>(random.below(5));
  word = word.substr(0, begin) + std::to_string(std::max(other, 0));
}

// Of a list of states: one lost, told otherwise (so may be those after it), with what another one says, once more.
void change_states(Rows& rows, gen::Prng& random) {
  const auto is_told = [](const Row& one) { return one[0] == "state" && one.size() > 1; };
  Row* row = pick(rows, random, is_told);
  if (row == nullptr) return;
  const std::size_t at = 1 + random.below(row->size() - 1);
  switch (random.below(5)) {
    case 0: {
      rows.erase(rows.begin() + (row - rows.data()));
      return;
    }
    case 1: {
      row->erase(row->begin() + static_cast<long>(at));
      return;
    }
    case 2: {
      change_number((*row)[at], random);
      return;
    }
    case 3: {
      const Row* other = pick(rows, random, is_told);
      row->push_back((*other)[1 + random.below(other->size() - 1)]);
      return;
    }
    default: {  // a little different
      Row more = *row;
      change_number(more[at], random);
      rows.insert(rows.begin() + (row - rows.data()) + static_cast<long>(random.below(2)), std::move(more));
    }
  }
}

void change(Rows& rows, gen::Prng& random) {
  switch (random.below(9)) {
    case 0: {  // a clause is lost
      if (Row* row = pick(rows, random, is_clause)) rows.erase(rows.begin() + (row - rows.data()));
      return;
    }
    case 1: {  // it is stronger, or a mode is forgotten
      const auto fits = [](const Row& row) {
        return (is_clause(row) || is_component(row)) && row.size() > first_word(row);
      };
      if (Row* row = pick(rows, random, fits))
        row->erase(row->begin() + static_cast<long>(first_word(*row) + random.below(row->size() - first_word(*row))));
      return;
    }
    case 2: {  // it is weaker: a word of another one
      Row* row = pick(rows, random, is_clause);
      if (row == nullptr) return;
      const bool sets = is_set(*row);
      Row* from = pick(rows, random, [&](const Row& other) {
        return is_clause(other) && is_set(other) == sets && (other[0] == "equation") == ((*row)[0] == "equation") &&
               other.size() > 1;
      });
      if (from != nullptr) row->push_back((*from)[1 + random.below(from->size() - 1)]);
      return;
    }
    case 3: {  // a number is another one
      const auto fits = [](const Row& row) {
        return (is_set(row) || is_component(row) || row[0] == "lemma" || row[0] == "equation" || is_mode(row)) &&
               row.size() > first_word(row);
      };
      if (Row* row = pick(rows, random, fits))
        change_number((*row)[first_word(*row) + random.below(row->size() - first_word(*row))], random);
      return;
    }
    case 4: {  // a literal is its opposite
      Row* row = pick(rows, random, [](const Row& one) { return one[0] == "lemma" && one.size() > 1; });
      if (row == nullptr) return;
      std::string& word = (*row)[1 + random.below(row->size() - 1)];
      word = word[0] == '!' ? word.substr(1) : '!' + word;
      return;
    }
    case 5: {  // one kind of set for the other
      if (Row* row = pick(rows, random, is_set)) (*row)[0] = (*row)[0] == "trap" ? "one-token" : "trap";
      return;
    }
    case 6: {  // two rows with each other's words
      Row* row = pick(rows, random, [](const Row& one) { return is_component(one) || is_mode(one) || is_set(one); });
      if (row == nullptr) return;
      Row* other = pick(rows, random, [&](const Row& one) { return one[0] == (*row)[0]; });
      const std::size_t keep = is_component(*row) ? 2 : first_word(*row);
      Row mine(row->begin() + static_cast<long>(keep), row->end()),
          theirs(other->begin() + static_cast<long>(keep), other->end());
      row->resize(keep);
      other->resize(keep);
      row->insert(row->end(), theirs.begin(), theirs.end());
      if (row != other) other->insert(other->end(), mine.begin(), mine.end());
      return;
    }
    case 7: {  // a mode that was not reachable is
      if (Row* row = pick(rows, random, is_component)) row->push_back(std::to_string(random.below(row->size() + 1)));
      return;
    }
    default: {  // all clauses of a kind but some
      std::erase_if(rows, [&](const Row& row) { return is_clause(row) && random.percent(30); });
    }
  }
}

}  // namespace

std::string mutate(const std::string& certificate, gen::Prng& random) {
  Rows rows;
  std::istringstream lines(certificate);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    rows.emplace_back();
    for (std::string word; words >> word;) rows.back().push_back(word);
  }
  const bool is_list = std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row[0] == "state"; });
  for (std::size_t left = 1 + random.below(3); left > 0; --left) (is_list ? change_states : change)(rows, random);
  std::string out;
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) out += (k == 0 ? "" : " ") + row[k];
    out += '\n';
  }
  return out;
}

}  // namespace bip::verify::test
