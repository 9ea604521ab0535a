// Prints connectors as text: inline, in the paper's notation, in the layout of `bipc fmt`.
#pragma once
#include <string>
#include <vector>

namespace bip::genom {

struct Wire {
  std::string name{};
  std::vector<std::string> ports;
  std::size_t triggers =
      0;  // the first so many ports, together, trigger; the others join if they can. 0: all are needed
  std::string guard{};
  std::string action{};     // one assignment, "a.b <- c"
  bool exported = false;    // as port `out`
  std::string report_to{};  // the port whose `rep` the one above may set, then `out` carries a report
  std::string report{};     // the report if that port does not set it
};
void write_wire(std::string& out, const Wire& wire);
/// `export port INNER as NAME`.
void write_export(std::string& out, const std::string& inner, const std::string& name);

}  // namespace bip::genom
