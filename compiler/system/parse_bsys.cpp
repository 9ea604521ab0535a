// Reads .bsys text: the tree of lists first, then row by row into the tables, then `validate`.
//
// Any bytes end in a sound System or in "line:column: what is wrong". Linear in the text; memory about 40 bytes an
// element.
#include <fmt/format.h>

#include <array>

#include "compiler/system/bsys.hpp"
#include "compiler/system/bsys_row_parser.hpp"
#include "compiler/system/validate_problems.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {
namespace {

using namespace text;

class BsysParser : BsysRowParser {
 public:
  using BsysRowParser::BsysRowParser;

  Result<System> run() {
    List all = reader_.open_bare(0);
    header(all);
    while (reader_.more(all)) row(reader_.next(all, "a row"));
    if (reader_.failed()) return reader_.failure();
    const std::vector<Problem> problems = find_problems(system_);
    BIP_ASSERT(rows_[static_cast<std::size_t>(Table::Atoms)].size() == system_.atoms.size(), "each atom has its line");
    BIP_ASSERT(rows_[static_cast<std::size_t>(Table::Connectors)].size() == system_.connectors.size(),
               "each connector has its line");
    if (problems.empty()) return std::move(system_);
    const Problem& problem = problems.front();
    const std::vector<std::uint32_t>& rows = rows_[static_cast<std::size_t>(problem.table)];
    const std::size_t offset = problem.row < rows.size() ? tree_.nodes[rows[problem.row]].begin : 0;
    return failure_at(tree_.text, offset, problem.message);
  }

 private:
  void header(List& all) {
    if (!reader_.more(all)) return reader_.fail(kNoNode, "expected `(bsys 1)`");
    const std::uint32_t node = reader_.next(all, "`(bsys 1)`");
    std::string_view head;
    List list = reader_.open(node, head);
    if (reader_.failed() || head != "bsys" || !reader_.flag(list, "1"))
      return reader_.fail(node, "the first row is `(bsys 1)`");
    reader_.close(list);
  }

  void row(std::uint32_t node) {
    std::string_view head;
    List list = reader_.open(node, head);
    if (reader_.failed()) return;
    if (head == "file") {
      reader_.row(list, system_.files.size());
      system_.files.push_back(reader_.quoted(list));
    } else if (head == "string") {
      reader_.row(list, system_.code.strings.size());
      if (!reader_.add_string(reader_.quoted(list)) && !reader_.failed())
        reader_.fail(node, "this string has a row already");
    } else if (head == "cpp") {
      cpp_file(node, list);
    } else if (head == "extern-type") {
      reader_.row(list, system_.code.ffi_types.size());
      FfiType row;
      row.name = reader_.name(list);
      row.cpp = reader_.quoted(list);
      reader_.close(list);
      row.loc = list.loc;
      system_.code.ffi_types.push_back(std::move(row));
    } else if (head == "function") {
      reader_.row(list, system_.code.functions.size());
      system_.code.functions.push_back(function(list));
    } else if (head == "port-type") {
      push(Table::PortTypes, node, system_.port_types, port_type(list));
    } else if (head == "atom-type") {
      push(Table::AtomTypes, node, system_.atom_types, atom_type(list));
    } else if (head == "connector-type") {
      push(Table::ConnectorTypes, node, system_.connector_types, connector_type(list));
    } else if (head == "compound") {
      push(Table::Compounds, node, system_.compounds, compound(list));
    } else if (head == "atom") {
      push(Table::Atoms, node, system_.atoms, atom(list));
    } else if (head == "choice") {
      rows_[static_cast<std::size_t>(Table::Choices)].push_back(node);
      system_.choices.push_back(choice(list));
    } else if (head == "connector") {
      push(Table::Connectors, node, system_.connectors, connector(list));
    } else if (head == "priority") {
      push(Table::Priorities, node, system_.priorities, priority(list));
    } else {
      reader_.fail(node, "no row begins with this word");
    }
    reader_.close(list);
  }
  void cpp_file(std::uint32_t node, List& list) {
    FfiFiles& cpp = system_.code.cpp;
    std::vector<CppFile>* files = nullptr;
    if (reader_.flag(list, "include")) files = &cpp.includes;
    else if (reader_.flag(list, "source")) files = &cpp.sources;
    else if (reader_.flag(list, "object")) files = &cpp.objects;
    if (files == nullptr) return reader_.fail(node, "a file of C++ is an include, a source or an object");
    CppFile file;
    file.folder = reader_.quoted(list);
    file.name = reader_.quoted(list);
    files->push_back(std::move(file));
  }
  Function function(List& list) {
    Function row;
    row.name = reader_.name(list);
    if (reader_.flag(list, "cast")) row.kind = FunctionKind::Cast;
    else if (reader_.flag(list, "operator")) row.kind = FunctionKind::Operator;
    else if (reader_.flag(list, "draw")) row.kind = FunctionKind::Draw;
    row.is_const = reader_.flag(list, "const");
    row.has_result = false;
    if (std::optional<List> result = reader_.sub(list, "result")) {
      row.has_result = true;
      row.result = reader_.type(*result);
      reader_.close(*result);
    }
    while (reader_.more(list)) {
      std::optional<List> param = reader_.sub(list, "value");
      const bool by_reference = !param;
      if (by_reference) param = reader_.need(list, "ref");
      row.params.push_back({reader_.type(*param), by_reference});
      reader_.close(*param);
    }
    row.loc = list.loc;
    return row;
  }
  template <class Rows, class Row>
  void push(Table table, std::uint32_t node, Rows& rows, Row row) {
    rows_[static_cast<std::size_t>(table)].push_back(node);
    rows.push(std::move(row));
  }

  std::array<std::vector<std::uint32_t>, kTables> rows_;
};

}  // namespace

Result<System> parse_bsys(std::string_view text) {
  Result<Tree> tree = read_tree(text);
  if (!tree) return Failure{tree.error()};
  return BsysParser(*tree).run();
}

}  // namespace bip::system
