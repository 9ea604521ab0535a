// Folded tables: what comes out is what went in, and arrays take a few rows.
#include <catch2/catch.hpp>

#include <random>

#include "compiler/lower/fold_tables.hpp"
#include "compiler/lower/lower.hpp"
#include "tests/unit/lower/hand_built.hpp"

using namespace bip;

namespace {

using u32 = std::uint32_t;

// Atoms as a model's arrays, arrays of compounds and single components would make them. Owns the names.
struct Atoms {
  std::vector<std::string> names;
  std::vector<rt::Atom> rows;  // names are set by finish()
  u32 variables = 0, args = 0;

  void add(const std::string& name, u32 type) {
    names.push_back(name);
    rows.push_back({nullptr, type, variables, args, {0, 10 + type, 3}});
    variables += type;
    args += type & 1;
  }
  const std::vector<rt::Atom>& finish() {
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].name = names[k].c_str();
    return rows;
  }
};

void check_same(const lower::Table<rt::Atom>& folded, const std::vector<rt::Atom>& all) {
  const rt::Rows<rt::Atom> view = folded.view();
  REQUIRE(view.size == all.size());
  u32 wrong = 0, k = 0;
  for (const rt::Atom& atom : view) {
    const rt::Atom& wanted = all[k++];
    wrong += atom.path() != wanted.name || atom.type != wanted.type || atom.first_cell != wanted.first_cell ||
             atom.args != wanted.args || atom.loc.line != wanted.loc.line;
  }
  CHECK(wrong == 0);
}

std::string indexed(const std::string& name, u32 k) { return name + "[" + std::to_string(k) + "]"; }

}  // namespace

TEST_CASE("an array stands as one row, an array of compounds as one of its elements") {
  Atoms atoms;
  for (u32 k = 0; k < 1000; ++k) atoms.add(indexed("ROOT.p", k), 2);
  for (u32 k = 0; k < 1000; ++k) {
    atoms.add(indexed("ROOT.cell", k) + ".a", 1);
    atoms.add(indexed("ROOT.cell", k) + ".b[7]", 3);
  }
  atoms.add("ROOT.last", 1);
  Arena arena;
  lower::Table<rt::Atom> table;
  table.rows = atoms.finish();
  lower::fold(table, arena);
  CHECK(table.rows.size() == 4);
  check_same(table, atoms.rows);
}

TEST_CASE("what does not repeat stands as it is") {
  Atoms atoms;
  for (u32 k = 0; k < 600; ++k) atoms.add(indexed("ROOT.p", k * k), 1);      // indices that do not follow each other
  for (u32 k = 0; k < 600; ++k) atoms.add("ROOT.q" + std::to_string(k), 1);  // numbers that are no indices
  for (u32 k = 0; k < 600; ++k) atoms.add(indexed("ROOT.r#", k), 1);         // `#` stands for an index
  for (u32 k = 0; k < 600; ++k) atoms.add(indexed("ROOT.s", 0) + indexed(".t", 5 * k), 1);
  Arena arena;
  lower::Table<rt::Atom> table;
  table.rows = atoms.finish();
  lower::fold(table, arena);
  CHECK(table.rows.size() == atoms.rows.size());
  CHECK(table.repeats.empty());
  check_same(table, atoms.rows);
}

TEST_CASE("small tables are left alone") {
  Atoms atoms;
  for (u32 k = 0; k + 1 < lower::kFewRows; ++k) atoms.add(indexed("ROOT.p", k), 2);
  Arena arena;
  lower::Table<rt::Atom> table;
  table.rows = atoms.finish();
  lower::fold(table, arena);
  CHECK(table.repeats.empty());
  check_same(table, atoms.rows);
}

TEST_CASE("a table that folding makes hardly smaller is not folded") {
  // One array among single components: a look at each of them would be a search.
  for (const u32 elements : {100u, 400u}) {
    Atoms atoms;
    for (u32 k = 0; k < 600; ++k) atoms.add("ROOT.single" + std::to_string(k), 1 + k % 5);
    for (u32 k = 0; k < elements; ++k) atoms.add(indexed("ROOT.p", k), 2);
    Arena arena;
    lower::Table<rt::Atom> table;
    table.rows = atoms.finish();
    lower::fold(table, arena);
    CHECK(table.repeats.empty() == (elements == 100));
    CHECK(table.rows.size() == (elements == 100 ? 700 : 601));
    check_same(table, atoms.rows);
  }
}

TEST_CASE("random tables come out as they went in") {
  for (u32 seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](u32 n) { return static_cast<u32>(random() % n); };
    Atoms atoms;
    for (u32 part = 0; part < 12; ++part) {
      const std::string name = "ROOT.x" + std::to_string(part);
      const u32 count = below(3) == 0 ? below(4) : below(120), inner = 1 + below(4), first = below(20),
                odd = below(400);
      for (u32 k = 0; k < count; ++k) {
        for (u32 i = 0; i < inner; ++i) {
          const std::string path = indexed(name, first + k) + (inner == 1        ? ""
                                                               : below(200) == 0 ? ".odd"
                                                                                 : indexed(".y", i));
          atoms.add(path, k * inner + i == odd ? 9 : i);
        }
      }
    }
    Arena arena;
    lower::Table<rt::Atom> table;
    table.rows = atoms.finish();
    lower::fold(table, arena);
    check_same(table, atoms.rows);
  }
}

TEST_CASE("the image does not need the System's instances") {
  System s = test::producers(5000);
  const auto l = lower::lower(s, "Root");
  s.atoms = {};
  s.connectors = {};
  CHECK(l->image.atoms.rows.size < 10);
  CHECK(l->image.port_refs.rows.size < 10);
  CHECK(l->image.atoms[4321].path() == "ROOT.p[4321]");
  CHECK(l->image.atoms[5000].path() == "ROOT.c");
  CHECK(l->image.atoms[4321].first_cell == 2 * 4321);
  CHECK(l->image.args[l->image.atoms[4321].args].i == 4322);
  CHECK(l->image.port_refs[4321].atom == 4321);
  CHECK(l->image.connectors[1].path() == "ROOT.take");
  CHECK(l->image.port_refs[l->image.connectors[1].ports].connector == 0);
}
