// See distributed_runs.hpp.
#include "compiler/driver/distributed_runs.hpp"

#include <limits>
#include <optional>

#include <fmt/format.h>

#include "compiler/base/read_file.hpp"
#include "compiler/driver/known_conflicts.hpp"
#include "compiler/driver/placement_report.hpp"
#include "runtime/distributed/faults.hpp"

namespace bip::driver {

std::string image_place_text(const rt::Image& image, const rt::SourceLine& loc) {
  return loc.line == 0 ? std::string() : fmt::format(" ({}:{}:{})", image.files[loc.file], loc.line, loc.column);
}

namespace {

constexpr PlacementReport::Limits kListAll{20, std::numeric_limits<std::size_t>::max()};

// Of a place of the image, if its text was read: one byte. A .bsys file has none.
SourceRange range_of(const Compilation& c, const rt::SourceLine& loc) {
  const FileId file(loc.file);
  if (loc.line == 0 || loc.file >= c.sources.size() || c.sources.name(file) != c.lowered->image.files[loc.file])
    return {};
  const std::string_view text = c.sources.text(file), line = c.sources.line(file, loc.line);
  if (loc.column == 0 || loc.column > line.size()) return {};
  const auto begin = static_cast<std::uint32_t>(line.data() - text.data()) + loc.column - 1;
  return {file, begin, begin + 1};
}

}  // namespace

bool is_distributable(Compilation& c) {
  const rt::TimeOnNodes time = rt::time_on_nodes(c.lowered->image);
  if (time.problem.empty()) return true;
  const SourceRange range = range_of(c, time.loc), open = range_of(c, time.open_bound);
  DiagnosticBuilder report = c.diags.report(Diag::kB5071, range, time.problem);
  if (open.is_valid() && open.begin == range.begin && open.file == range.file)
    report.label("`eager`, and a bound with `>`");
  else if (open.is_valid()) report.label("`eager`").label(open, "a bound with `>`");
  report.note(time.why).help(time.help);
  return false;
}

bool crosses_nothing(Compilation& c, const LinkedModel& linked, const rt::Distribution& distribution) {
  const rt::Image& image = c.lowered->image;
  for (const rt::CrossingObject& object : distribution.crossing) {
    const auto node = [&](std::uint32_t atom) { return distribution.placement.nodes[distribution.home(atom)]; };
    const std::string path = image.atoms[object.atom].path(), other = image.atoms[object.other].path();
    const rt::Connector connector = image.connectors[linked.tables.connector_of(object.meeting)];
    c.diags
        .report(Diag::kB5072, range_of(c, connector.loc),
                linked.tables.atom_type(object.atom).variables[object.variable].name, path, node(object.atom), other,
                node(object.other))
        .note(fmt::format("what C++ keeps in an object cannot be sent over `{}`{}", connector.path(),
                          image_place_text(image, connector.loc)))
        .help(fmt::format("put `{}` and `{}` on one node", path, other));
  }
  return distribution.crossing.empty();
}

bool prepare_distributed(Compilation& c, const RunArguments& arguments, rt::Placement& placement) {
  if (!rt::has_nodes(arguments.run.engine) && arguments.placement_path.empty()) return true;
  if (!is_distributable(c)) return false;
  const LinkedModel linked(c.lowered->image,
                           arguments.run.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off);
  if (arguments.placement_path.empty()) placement = rt::place_atoms(linked.tables, linked.rules, arguments.run.nodes);
  else if (!read_placement(c, arguments.placement_path, placement)) return false;
  if (arguments.split_above != 0) placement.split_above = arguments.split_above;
  if (const Result<rt::NetworkFaults> faults = rt::read_faults(arguments.run.network_faults, placement.nodes);
      !faults) {
    c.diags.report(Diag::kB5070, {}, faults.error());
    return false;
  }
  placement.next_moves = prove_next_moves(c).moves;
  return crosses_nothing(c, linked, rt::distribute(linked.tables, linked.rules, placement));
}

bool prepare_deployed(Compilation& c, const std::string& placement_path, const std::string& moves_path,
                      rt::Placement& placement) {
  if (!is_distributable(c) || !read_placement(c, placement_path, placement)) return false;
  if (moves_path.empty()) {
    placement.next_moves = prove_next_moves(c).moves;
  } else {
    const std::optional<std::string> text = read_file(moves_path);
    Result<std::vector<rt::NextMove>> moves = Failure{"it cannot be read"};
    if (text) moves = read_next_moves(c.lowered->image, *text);
    if (!moves) {
      c.diags.report(Diag::kB6120, {}, moves_path, moves.error()).help("deploy again, and copy all folders");
      return false;
    }
    placement.next_moves = std::move(*moves);
  }
  const LinkedModel linked(c.lowered->image);
  return crosses_nothing(c, linked, rt::distribute(linked.tables, linked.rules, placement));
}

std::string distribution_text(Compilation& c, const std::string& placement_path) {
  const std::optional<PlacementReport> report = report_placement(c, placement_path, {});
  return report ? placement_text(*report) : std::string();
}

std::string distribution_json(Compilation& c, const std::string& file, const std::string& placement_path) {
  std::optional<PlacementReport> report;
  if (!c.diags.has_errors()) report = report_placement(c, placement_path, kListAll);
  return placement_json(c, file, placement_path, report ? &*report : nullptr);
}

}  // namespace bip::driver
