// See run_writer.hpp.
#include "compiler/traces/run_writer.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/graph/picture.hpp"
#include "compiler/system/system_parts.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"

namespace bip::traces {

namespace {

std::string without_root(const std::string& path) { return path.starts_with("ROOT.") ? path.substr(5) : path; }

std::string value_text(const rt::Core& core, rt::u32 atom, std::size_t variable) {
  std::string out;
  rt::append_value(out, core.image(), core.tables().atom_type(atom).variables[variable].type,
                   core.cell(core.image().atoms[atom].variable(static_cast<rt::u32>(variable))));
  return out;
}

// -- CSV: a row for each component that takes part --

class CsvWriter final : public RunWriter {
 public:
  CsvWriter(const System& system, const Selection& selection) : system_(system), selection_(selection) {}

  void begin(std::string& out, const rt::Core&) override {
    out += "step,instant_ns,interaction,component,port,place,data\r\n";
  }
  void step(std::string& out, const rt::Core& core, const TracedStep& step, Wanted wanted) override {
    if (wanted == Wanted::No) return;
    for (const rt::MovePart& part : *step.parts) {
      const std::string path = core.image().atoms[part.atom].path();
      if (!selection_.takes_component(path)) continue;
      const AtomType& type = system::type_of_atom(system_, part.atom);
      std::string data;
      for (std::size_t k = 0; k < type.visible_variables(); ++k)
        data += (k > 0 ? "; " : "") + type.variables[k].name + "=" + value_text(core, part.atom, k);
      out += fmt::format("{},{},{},{},{},{},{}\r\n", step.number, step.instant, quoted(without_root(step.interaction)),
                         quoted(without_root(path)), type.ports[part.port].name, quoted(rt::places_of(core, part.atom)),
                         quoted(data));
    }
  }
  void end(std::string&) override {}

 private:
  // RFC 4180.
  static std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + '"';
  }

  const System& system_;
  const Selection& selection_;
};

// -- VCD: places and data of each component, an event for each connector --

class VcdWriter final : public RunWriter {
 public:
  VcdWriter(const System& system, const Selection& selection) : system_(system), selection_(selection) {}

  void begin(std::string& out, const rt::Core& core) override {
    is_timed_ = core.is_timed();
    out += "$version bipc $end\n$comment " + std::string(is_timed_ ? "instants of the model" : "a step each unit") +
           " $end\n$timescale 1ns $end\n";
    std::vector<std::string> open;
    for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
      const std::string path = core.image().atoms[atom].path();
      if (!selection_.takes_component(path)) continue;
      enter(out, open, path);
      declare(out, atom, kPlace, "string 1", "place");
      const AtomType& type = system::type_of_atom(system_, atom);
      for (std::size_t k = 0; k < type.visible_variables(); ++k) {
        const rt::CellType cell = core.tables().atom_type(atom).variables[k].type;
        const char* const kind = cell == rt::CellType::Int     ? "integer 32"
                                 : cell == rt::CellType::Bool  ? "wire 1"
                                 : cell == rt::CellType::Float ? "real 64"
                                                               : "string 1";
        declare(out, atom, static_cast<rt::u32>(k), kind, type.variables[k].name);
      }
    }
    leave(out, open, 0);
    out += "$scope module interactions $end\n";
    for (rt::u32 k = 0; k < core.image().connectors.size; ++k) {
      const std::string path = core.image().connectors[k].path();
      events_[path] = identifier(next_++);
      out += fmt::format("$var event 1 {} {} $end\n", events_[path], without_root(path));
    }
    out += "$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n";
    write_changes(out, core);
    out += "$end\n";
  }
  void step(std::string& out, const rt::Core& core, const TracedStep& step, Wanted wanted) override {
    if (step.number > selection_.last || step.instant > selection_.end) return;
    // Outside of the wanted span the state goes on; at its begin all is written at once.
    if (step.number < selection_.first || step.instant < selection_.begin) return;
    std::string changes;
    write_changes(changes, core);
    const auto event = events_.find(step.interaction);
    if (wanted == Wanted::Yes && event != events_.end()) changes += "1" + event->second + "\n";
    if (changes.empty()) return;
    const rt::i64 instant = is_timed_ ? step.instant : static_cast<rt::i64>(step.number + 1);
    BIP_ASSERT(instant >= last_, "a wave at {} behind one at {}", instant, last_);
    if (instant != last_) out += fmt::format("#{}\n", instant);
    last_ = instant;
    out += changes;
  }
  void end(std::string&) override {}

 private:
  static constexpr rt::u32 kPlace = ~rt::u32{0};
  struct Wave {
    rt::u32 atom, variable;
    char kind;  // of "string 1", "integer 32", …: its first letter
    std::string id, last;
  };

  // Printable characters, as the format has them.
  static std::string identifier(std::size_t number) {
    std::string out;
    do {
      out += static_cast<char>('!' + number % 94);
      number /= 94;
    } while (number > 0);
    return out;
  }
  void declare(std::string& out, rt::u32 atom, rt::u32 variable, const char* kind, const std::string& name) {
    waves_.push_back({atom, variable, kind[0], identifier(next_++), {}});
    out += fmt::format("$var {} {} {} $end\n", kind, waves_.back().id, name);
  }
  static void leave(std::string& out, std::vector<std::string>& open, std::size_t depth) {
    for (; open.size() > depth; open.pop_back()) out += "$upscope $end\n";
  }
  // A scope for each compound, and one for the atom.
  static void enter(std::string& out, std::vector<std::string>& open, const std::string& path) {
    std::vector<std::string> words;
    for (std::size_t at = 0; at <= path.size();) {
      const std::size_t dot = std::min(path.find('.', at), path.size());
      words.push_back(path.substr(at, dot - at));
      at = dot + 1;
    }
    std::size_t same = 0;
    while (same < open.size() && same < words.size() && open[same] == words[same]) ++same;
    leave(out, open, same);
    for (; same < words.size(); ++same) {
      out += "$scope module " + words[same] + " $end\n";
      open.push_back(words[same]);
    }
  }
  void write_changes(std::string& out, const rt::Core& core) {
    for (Wave& wave : waves_) {
      std::string now =
          wave.variable == kPlace ? rt::places_of(core, wave.atom) : value_text(core, wave.atom, wave.variable);
      if (now == wave.last) continue;
      wave.last = now;
      switch (wave.kind) {
        case 'w': out += (now == "true" ? "1" : "0") + wave.id + "\n"; break;
        case 'r': out += "r" + now + " " + wave.id + "\n"; break;
        case 'i':
          out += fmt::format("b{:b} {}\n", static_cast<std::uint32_t>(std::strtol(now.c_str(), nullptr, 10)), wave.id);
          break;
        default:
          // A string has no blanks.
          std::replace_if(
              now.begin(), now.end(), [](char c) { return c <= ' '; }, '_');
          out += "s" + (now.empty() ? "_" : now) + " " + wave.id + "\n";
      }
    }
  }

  const System& system_;
  const Selection& selection_;
  std::vector<Wave> waves_;
  std::map<std::string, std::string> events_;
  std::size_t next_ = 0;
  rt::i64 last_ = 0;
  bool is_timed_ = false;
};

// -- A chart: a column for each component that takes part, a row for each step --

class ChartWriter final : public RunWriter {
 public:
  ChartWriter(const System& system, const Selection& selection) : system_(system), selection_(selection) {}

  void begin(std::string&, const rt::Core& core) override { is_timed_ = core.is_timed(); }
  void step(std::string&, const rt::Core& core, const TracedStep& step, Wanted wanted) override {
    if (wanted == Wanted::No || ++count_ > kMostChartSteps) return;
    Row row{step.number, step.instant, without_root(step.interaction), {}};
    for (const rt::MovePart& part : *step.parts)
      if (selection_.takes_component(core.image().atoms[part.atom].path())) {
        row.parts.push_back({part.atom, part.port, rt::places_of(core, part.atom)});
        columns_[part.atom] = 0;
      }
    rows_.push_back(std::move(row));
  }
  [[nodiscard]] std::string problem() const override {
    if (count_ <= kMostChartSteps) return {};
    return fmt::format("a chart has at most {} steps, and these are {}: --first and --last say which", kMostChartSteps,
                       count_);
  }
  void end(std::string& out) override {
    constexpr int kLeft = 230, kColumn = 130, kRow = 26, kTop = 44;
    BIP_ASSERT(rows_.size() == count_, "{} of {} steps are in the chart", rows_.size(), count_);
    int x = 0;
    for (auto& [atom, column] : columns_) column = kLeft + kColumn / 2 + kColumn * x++;
    const int width = kLeft + kColumn * x + 20, height = kTop + kRow * static_cast<int>(rows_.size()) + 16;
    out += fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\">\n"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
        width, height);
    for (const auto& [atom, at] : columns_) {
      const std::string name = without_root(system::atom_path(system_, atom));
      out += fmt::format(
          "<text x=\"{0}\" y=\"18\" text-anchor=\"middle\" font-weight=\"bold\"{2}>{1}</text>"
          "<line x1=\"{0}\" x2=\"{0}\" y1=\"26\" y2=\"{3}\" stroke=\"#d1d9e0\"/>\n",
          at, graph::escaped_markup(name), fitted(name, kColumn - 8), height - 8);
    }
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const Row& row = rows_[k];
      const int y = kTop + kRow * static_cast<int>(k);
      std::string label = fmt::format("#{} {}", row.number, row.interaction);
      if (is_timed_) {
        label = " " + label;
        std::string time;
        rt::append_time(time, row.instant);
        label = time + label;
      }
      out += fmt::format("<text x=\"4\" y=\"{}\"{}>{}</text>\n", y + 4, fitted(label, kLeft - 14),
                         graph::escaped_markup(label));
      if (row.parts.empty()) continue;
      const auto [low, high] = std::minmax_element(row.parts.begin(), row.parts.end(),
                                                   [](const Part& a, const Part& b) { return a.atom < b.atom; });
      out += fmt::format("<line x1=\"{}\" x2=\"{}\" y1=\"{}\" y2=\"{}\" stroke=\"#0969da\" stroke-width=\"2\"/>\n",
                         columns_[low->atom], columns_[high->atom], y, y);
      for (const Part& part : row.parts) {
        const int at = columns_[part.atom];
        const AtomType& type = system::type_of_atom(system_, part.atom);
        const std::string& port = type.ports[part.port].name;
        out += fmt::format(
            "<circle cx=\"{0}\" cy=\"{1}\" r=\"4\" fill=\"#0969da\"/><text x=\"{2}\" y=\"{3}\" "
            "font-size=\"9\"{6}>{4}</text>"
            "<text x=\"{2}\" y=\"{7}\" font-size=\"9\" fill=\"#59636e\"{8}>{5}</text>\n",
            at, y, at + 6, y - 3, graph::escaped_markup(port), graph::escaped_markup(part.place),
            fitted(port, kColumn / 2 - 8), y + 10, fitted(part.place, kColumn / 2 - 8));
      }
    }
    out += "</svg>\n";
  }

 private:
  struct Part {
    rt::u32 atom, port;
    std::string place;
  };
  struct Row {
    std::uint64_t number;
    rt::i64 instant;
    std::string interaction;
    std::vector<Part> parts;
  };
  // Long texts are made narrower rather than drawn over their neighbours.
  static std::string fitted(const std::string& text, int room) {
    if (static_cast<int>(text.size()) * 6 <= room) return {};
    return fmt::format(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", room);
  }

  const System& system_;
  const Selection& selection_;
  bool is_timed_ = false;
  std::size_t count_ = 0;
  std::vector<Row> rows_;
  std::map<rt::u32, int> columns_;
};

}  // namespace

std::unique_ptr<RunWriter> make_run_writer(WrittenAs format, const System& system, const Selection& selection) {
  switch (format) {
    case WrittenAs::Csv: return std::make_unique<CsvWriter>(system, selection);
    case WrittenAs::Vcd: return std::make_unique<VcdWriter>(system, selection);
    case WrittenAs::Chart: return std::make_unique<ChartWriter>(system, selection);
  }
  BIP_UNREACHABLE("a format of runs");
}

}  // namespace bip::traces
