// Reads .bsys text: the tree of lists first, then row by row into the tables, then `validate`.
//
// Any bytes end in a sound System or in "line:column: what is wrong". Linear in the text; memory about 40 bytes an
// element.
#include <fmt/format.h>

#include <array>

#include "compiler/system/bsys.hpp"
#include "compiler/system/parse_bsys_rows.hpp"
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

using namespace text;

class BsysParser : RowParser {
 public:
  using RowParser::RowParser;

  Result<System> run() {
    List all = r_.open_bare(0);
    header(all);
    while (r_.more(all)) row(r_.next(all, "a row"));
    if (r_.failed()) return r_.failure();
    const std::vector<Problem> problems = find_problems(s_);
    if (problems.empty()) return std::move(s_);
    const Problem& problem = problems.front();
    const std::vector<std::uint32_t>& rows = rows_[static_cast<std::size_t>(problem.table)];
    const std::size_t offset = problem.row < rows.size() ? tree_.nodes[rows[problem.row]].begin : 0;
    return failure_at(tree_.text, offset, problem.message);
  }

 private:
  void header(List& all) {
    if (!r_.more(all)) return r_.fail(kNoNode, "expected `(bsys 1)`");
    const std::uint32_t node = r_.next(all, "`(bsys 1)`");
    std::string_view head;
    List list = r_.open(node, head);
    if (r_.failed() || head != "bsys" || !r_.flag(list, "1")) return r_.fail(node, "the first row is `(bsys 1)`");
    r_.close(list);
  }

  void row(std::uint32_t node) {
    std::string_view head;
    List list = r_.open(node, head);
    if (r_.failed()) return;
    if (head == "file") {
      r_.row(list, s_.files.size());
      s_.files.push_back(r_.quoted(list));
    } else if (head == "string") {
      r_.row(list, s_.code.strings.size());
      if (!r_.add_string(r_.quoted(list)) && !r_.failed()) r_.fail(node, "this string has a row already");
    } else if (head == "cpp") {
      cpp_file(node, list);
    } else if (head == "extern-type") {
      r_.row(list, s_.code.ffi_types.size());
      FfiType row;
      row.name = r_.name(list);
      row.cpp = r_.quoted(list);
      r_.close(list);
      row.loc = list.loc;
      s_.code.ffi_types.push_back(std::move(row));
    } else if (head == "function") {
      r_.row(list, s_.code.functions.size());
      s_.code.functions.push_back(function(list));
    } else if (head == "port-type") {
      push(Table::PortTypes, node, s_.port_types, port_type(list));
    } else if (head == "atom-type") {
      push(Table::AtomTypes, node, s_.atom_types, atom_type(list));
    } else if (head == "connector-type") {
      push(Table::ConnectorTypes, node, s_.connector_types, connector_type(list));
    } else if (head == "compound") {
      push(Table::Compounds, node, s_.compounds, compound(list));
    } else if (head == "atom") {
      push(Table::Atoms, node, s_.atoms, atom(list));
    } else if (head == "choice") {
      rows_[static_cast<std::size_t>(Table::Choices)].push_back(node);
      s_.choices.push_back(choice(list));
    } else if (head == "connector") {
      push(Table::Connectors, node, s_.connectors, connector(list));
    } else if (head == "priority") {
      push(Table::Priorities, node, s_.priorities, priority(list));
    } else {
      r_.fail(node, "no row begins with this word");
    }
    r_.close(list);
  }
  void cpp_file(std::uint32_t node, List& list) {
    FfiFiles& cpp = s_.code.cpp;
    std::vector<CppFile>* files = nullptr;
    if (r_.flag(list, "include")) files = &cpp.includes;
    else if (r_.flag(list, "source")) files = &cpp.sources;
    else if (r_.flag(list, "object")) files = &cpp.objects;
    if (files == nullptr) return r_.fail(node, "a file of C++ is an include, a source or an object");
    CppFile file;
    file.folder = r_.quoted(list);
    file.name = r_.quoted(list);
    files->push_back(std::move(file));
  }
  Function function(List& list) {
    Function row;
    row.name = r_.name(list);
    if (r_.flag(list, "cast")) row.kind = FunctionKind::Cast;
    else if (r_.flag(list, "operator")) row.kind = FunctionKind::Operator;
    row.is_const = r_.flag(list, "const");
    row.has_result = false;
    if (std::optional<List> result = r_.sub(list, "result")) {
      row.has_result = true;
      row.result = r_.type(*result);
      r_.close(*result);
    }
    while (r_.more(list)) {
      std::optional<List> param = r_.sub(list, "value");
      const bool by_reference = !param;
      if (by_reference) param = r_.need(list, "ref");
      row.params.push_back({r_.type(*param), by_reference});
      r_.close(*param);
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
