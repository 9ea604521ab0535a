// Checks a batch of models as one C++ program: the emitted texts in sequence, and a main() that executes every run and
// writes each trace with its length before it. Compiled with -O0, which finds errors of emission; errors of g++'s
// optimiser are out of scope. Runs of the engines with several threads are checked inside the program, which writes one
// record per model with its counts or the failure.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tools/gen/check_model.hpp"
#include "tools/gen/traced_run.hpp"

namespace bip::gen {
namespace {

std::string quoted(const std::string& text) { return "'" + text + "'"; }

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

/// All models, then `run_all` for each of them.
std::string whole_program(const std::vector<EmittedCase>& cases, const std::string& run_all) {
  std::string text;
  for (const EmittedCase& c : cases) text += c.source + "\n";
  text += run_all + "int main() {\n";
  for (const EmittedCase& c : cases) {
    std::string seed = std::to_string(c.seed);
    text += "  run_all(m" + seed + "::image(), " + seed + "u);\n";
  }
  return text + "}\n";
}

std::string engines_program(const std::vector<EmittedCase>& cases, const CheckOptions& options) {
  return whole_program(cases,
                       "#include \"tools/gen/engine_runs.hpp\"\n"
                       "static void run_all(const bip::rt::Image& image, std::uint64_t seed) {\n"
                       "  bip::gen::EngineCounts n;\n"
                       "  std::string t = bip::gen::engine_runs(image, seed, " +
                           std::to_string(options.engine_runs) + ", " + std::to_string(options.steps) +
                           ", n);\n"
                           "  if (t.empty()) t = std::to_string(n.runs) + \" \" + std::to_string(n.steps) + \" \" + "
                           "std::to_string(n.in_parts) + \" \" + std::to_string(n.timed);\n"
                           "  std::printf(\"%zu\\n\", t.size());\n  std::fwrite(t.data(), 1, t.size(), stdout);\n  "
                           "std::fflush(stdout);\n}\n");
}

std::string program(const std::vector<EmittedCase>& cases, std::uint64_t steps) {
  return whole_program(
      cases,
      "#include \"tools/gen/traced_run.hpp\"\n"
      "static void run_all(const bip::rt::Image& image, std::uint64_t seed) {\n"
      "  for (int k = 0; k < bip::gen::kRunSpecs; ++k) {\n"
      "    std::string t = bip::gen::traced_run(image, bip::gen::run_spec(k, seed, " +
          std::to_string(steps) +
          "));\n"
          "    std::printf(\"%zu\\n\", t.size());\n    std::fwrite(t.data(), 1, t.size(), stdout);\n  }\n}\n");
}

/// The next "<length>\n<bytes>" record.
std::string next_record(const std::string& all, std::size_t& at) {
  std::size_t end = all.find('\n', at);
  if (end == std::string::npos) return "";
  std::size_t size = std::strtoull(all.c_str() + at, nullptr, 10);
  std::string record = all.substr(end + 1, size);
  at = end + 1 + size;
  return record;
}

/// Only the first lines of a compiler's or sanitizer's complaint.
std::string head(const std::string& text) { return text.substr(0, 600); }

/// "runs steps in_parts timed", as engines_program writes them. False: it is something else.
bool read_counts(const std::string& record, EngineCounts& counts) {
  unsigned long long runs = 0, steps = 0, in_parts = 0, timed = 0;
  if (std::sscanf(record.c_str(), "%llu %llu %llu %llu", &runs, &steps, &in_parts, &timed) != 4) return false;
  counts.add({runs, steps, in_parts, 0, timed});
  return true;
}

}  // namespace

std::vector<Failure> check_emitted(const std::vector<EmittedCase>& cases, const CheckOptions& options,
                                   const std::string& name, EngineCounts& counts) {
  std::vector<Failure> failures;
  if (cases.empty()) return failures;
  std::string base = options.work_dir + "/" + name;
  std::ofstream(base + ".cpp") << (options.engine_runs != 0 ? engines_program(cases, options)
                                                            : program(cases, options.steps));
  std::string root = options.source_dir;
  std::string command = "ccache g++ -std=c++20 -O0 -ffp-contract=off -fuse-ld=mold " + options.cxx_flags + " -I" +
                        quoted(root) + " -I" + quoted(root + "/runtime/include") + " -I" + quoted(root + "/runtime") +
                        " -I" + quoted(root + "/tools/gen/ffi") + " " + quoted(base + ".cpp") + " " +
                        quoted(options.runtime_lib) + " -lpthread -o " + quoted(base + ".exe") + " >" +
                        quoted(base + ".log") + " 2>&1";
  if (std::system(command.c_str()) != 0) {
    if (cases.size() == 1) return {{cases[0].seed, "emitted C++: does not compile, " + head(read_file(base + ".log"))}};
    // Each half by itself, until the guilty ones are alone.
    std::size_t half = cases.size() / 2;
    std::vector<EmittedCase> left(cases.begin(), cases.begin() + static_cast<std::ptrdiff_t>(half));
    std::vector<EmittedCase> right(cases.begin() + static_cast<std::ptrdiff_t>(half), cases.end());
    failures = check_emitted(left, options, name + "l", counts);
    for (Failure& f : check_emitted(right, options, name + "r", counts)) failures.push_back(std::move(f));
    return failures;
  }
  // Seconds of the processor: on a busy machine the clock says nothing about the program.
  command = "ulimit -t " + std::string(options.engine_runs != 0 ? "1200" : "60") + "; " + quoted(base + ".exe") + " >" +
            quoted(base + ".out") + " 2>" + quoted(base + ".err");
  int status = std::system(command.c_str());
  std::string all = read_file(base + ".out");
  std::size_t at = 0;
  for (const EmittedCase& c : cases) {
    if (options.engine_runs != 0) {
      const std::string said = next_record(all, at);
      if (!said.empty() && read_counts(said, counts)) continue;
      failures.push_back(
          {c.seed, "emitted C++: " + (said.empty() ? "program stopped, status " + std::to_string(status) + "\n" +
                                                         head(read_file(base + ".err"))
                                                   : said)});
      if (said.empty()) break;
    }
    for (std::size_t k = 0; k < c.traces.size(); ++k) {
      std::string got = next_record(all, at);
      if (got == c.traces[k]) continue;
      std::string why = got.empty() && status != 0 ? "program stopped, status " + std::to_string(status)
                                                   : first_difference(c.traces[k], got);
      failures.push_back({c.seed, "interp against emitted C++: run " + std::to_string(k) + ", " + why});
      for (std::size_t rest = k + 1; rest < c.traces.size(); ++rest) (void)next_record(all, at);
      break;
    }
  }
  for (const char* suffix : {".cpp", ".exe", ".out", ".err", ".log"}) std::remove((base + suffix).c_str());
  return failures;
}

}  // namespace bip::gen
