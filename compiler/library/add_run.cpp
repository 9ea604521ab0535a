// See add_run.hpp.
#include "compiler/library/add_run.hpp"

#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"

namespace bip::library {

void add_run(nlohmann::ordered_json& json, const std::string& run) {
  const nlohmann::ordered_json members = parse_json(run);
  if (members.is_object()) json.update(members);
}

}  // namespace bip::library
