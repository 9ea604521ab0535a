// See exploration_json.hpp.
#include "compiler/driver/exploration_json.hpp"

#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/library/add_run.hpp"

namespace bip::driver {

namespace {

const char* name_of(rt::StateReduction reduction) {
  return reduction == rt::StateReduction::None ? "none" : reduction == rt::StateReduction::Por ? "por" : "symmetry";
}

nlohmann::ordered_json run_json(const rt::Image& image, rt::MaximalProgress progress, rt::CounterexampleEnd end,
                                const rt::Path& path, const std::string& text) {
  nlohmann::ordered_json json{{"choices", path}, {"text", text}};
  library::add_run(json, rt::counterexample_json(image, progress, end, rt::at_once(path)));
  return json;
}

}  // namespace

std::string exploration_json(const ExploreArguments& arguments, const rt::Image& image, const rt::ExploreReport& found,
                             const ShownRuns& runs) {
  nlohmann::ordered_json json{{"format", "bipc-exploration"}, {"version", 1},
                              {"end", name_of(found.end)},    {"reduction", name_of(arguments.explore.reduction)},
                              {"states", found.states},       {"steps", found.steps},
                              {"deadlocks", found.deadlocks}, {"errors", found.errors},
                              {"depth", found.depth},         {"bits", found.bits}};
  if (found.has_final_states) json["final_states"] = found.finals;
  if (!found.groups.empty()) json["interchangeable"] = found.groups;
  if (arguments.stats) {
    json["seconds"] = found.seconds;
    json["bytes"] = found.bytes;
    json["threads"] = found.threads;
  }
  if (found.has_deadlock && found.are_paths_known)
    json["deadlock"] = run_json(image, arguments.explore.progress, rt::CounterexampleEnd::Deadlock, found.deadlock,
                                runs.deadlock.steps);
  if (found.has_error && found.are_paths_known)
    json["error"] = run_json(image, arguments.explore.progress, rt::CounterexampleEnd::Error, found.error,
                             runs.error.steps + runs.error.error);
  return json_line(json) + '\n';
}

}  // namespace bip::driver
