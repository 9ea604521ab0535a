// See profile.hpp. Interactions of one declaration are one row, so that a table has as many rows as the model has
// lines.
#include "runtime/core/profile.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <tuple>

namespace bip::rt {

namespace {

std::int32_t nothing(const void*, Cell*, Cell*, const std::uint32_t*) { return 1; }

// The path with `*` for each index.
std::string pattern_of(const char* path) {
  std::string out;
  for (const char* at = path; *at != '\0'; ++at) {
    out += *at;
    if (*at != '[') continue;
    const char* digit = at + 1;
    while (*digit >= '0' && *digit <= '9') ++digit;
    if (*digit != ']' || digit == at + 1) continue;
    out += '*';
    at = digit - 1;
  }
  return out;
}

}  // namespace

#if !defined(__x86_64__)
std::uint64_t Profile::ticks_now() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}
#endif

Profile::Profile(std::vector<Code>& codes) : codes_(codes), rows_(codes.size()) {
  calibrate();
  for (std::size_t row = 0; row < codes_.size(); ++row) {
    rows_[row].code = codes_[row];
    rows_[row].owner = this;
    if (codes_[row].fn != nullptr) codes_[row] = {&Profile::call, &rows_[row]};
  }
}

Profile::~Profile() {
  for (std::size_t row = 0; row < codes_.size(); ++row) codes_[row] = rows_[row].code;
}

std::int32_t Profile::call(const void* context, Cell* self, Cell* all, const std::uint32_t* bind) {
  // The rows are the owner's own and not constant; the type of a context is.
  auto& row = *const_cast<Row*>(static_cast<const Row*>(context));
  const std::uint64_t from = ticks_now();
  const std::int32_t status = row.code.fn(row.code.context, self, all, bind);
  const std::uint64_t took = ticks_now() - from;
  ++row.count.calls;
  row.count.holds += status == 1 ? 1 : 0;
  row.count.ticks += took;
  ++row.owner->code_calls_;
  row.owner->code_ticks_ += took;
  return status;
}

// The least of many rounds: what disturbs a round makes it longer.
void Profile::calibrate() {
  constexpr std::uint64_t kCalls = 256;
  Row row{{&nothing, nullptr}, this, {}};
  const volatile CodeFn measured = &Profile::call, plain = &nothing;
  shown_ = cost_ = 1e9;
  for (int round = 0; round < 64; ++round) {
    row.count = {};
    std::uint64_t from = ticks_now();
    for (std::uint64_t k = 0; k < kCalls; ++k) (void)measured(&row, nullptr, nullptr, nullptr);
    const auto with = static_cast<double>(ticks_now() - from);
    from = ticks_now();
    for (std::uint64_t k = 0; k < kCalls; ++k) (void)plain(nullptr, nullptr, nullptr, nullptr);
    const auto without = static_cast<double>(ticks_now() - from);
    shown_ = std::min(shown_, static_cast<double>(row.count.ticks) / kCalls);
    cost_ = std::min(cost_, std::max(with - without, 0.0) / kCalls);
  }
}

void Profile::start(const Tables& tables) {
  const Image& image = *tables.image;
  // Type, file, line, column; an internal port has no connector's type.
  using Key = std::tuple<bool, u32, u32, u32, u32, u32>;
  std::map<Key, u32> known;
  for (const InteractionId interaction : tables.interactions.ids()) {
    const InteractionInfo info = tables.interactions[interaction];
    InteractionProfile row;
    std::string path;
    if (info.kind == InteractionKind::Port) {
      const u32 atom = tables.port_atom[info.row];
      row.atom_type = image.atoms[atom].type;
      row.port = info.row - tables.port_base(atom);
      row.loc = tables.atom_type(atom).ports[row.port].loc;
      path = image.atoms[atom].path() + "." + tables.atom_type(atom).ports[row.port].name;
    } else {
      row.connector_type = image.connectors[info.row].type;
      row.loc = image.connectors[info.row].loc;
      path = image.connectors[info.row].path();
    }
    const bool is_port = info.kind == InteractionKind::Port;
    const Key key{
        is_port,       is_port ? row.atom_type : row.connector_type, is_port ? row.port : 0, row.loc.file, row.loc.line,
        row.loc.column};
    const auto [at, is_new] = known.try_emplace(key, static_cast<u32>(interactions_.size()));
    interaction_of_.push(at->second);
    if (is_new) {
      row.name = std::move(path);
      row.instances = 1;
      interactions_.push_back(std::move(row));
      continue;
    }
    InteractionProfile& group = interactions_[at->second];
    ++group.instances;
    // Of different paths what they have in common at the end.
    const std::string pattern = pattern_of(path.c_str());
    if (group.instances == 2) group.name = pattern_of(group.name.c_str());
    if (group.name == pattern) continue;
    const std::size_t dot = pattern.rfind('.');
    group.name = "*." + (dot == std::string::npos ? pattern : pattern.substr(dot + 1));
  }
  // What ran for the initial state is no step's.
  for (Row& row : rows_) row.count = {};
  started_ = ticks_now();
}

void Profile::finish(double seconds) {
  seconds_ = seconds;
  const auto ticks = static_cast<double>(ticks_now() - started_);
  seconds_per_tick_ = ticks > 0 ? seconds / ticks : 0;
}

double Profile::seconds_of(const InteractionProfile& row) const {
  return in_seconds(static_cast<double>(row.ticks) - static_cast<double>(row.steps) * shown_ -
                    static_cast<double>(row.code_calls) * cost_);
}
double Profile::code_seconds_of(const InteractionProfile& row) const {
  return in_seconds(static_cast<double>(row.code_ticks) - static_cast<double>(row.code_calls) * shown_);
}
double Profile::seconds_of(const CodeProfile& row) const {
  return in_seconds(static_cast<double>(row.ticks) - static_cast<double>(row.calls) * shown_);
}
double Profile::measuring_seconds() const {
  std::uint64_t pieces = 0;
  for (const InteractionProfile& row : interactions_) pieces += row.steps;
  for (const Row& row : rows_) pieces += row.count.calls;
  return std::min(in_seconds(static_cast<double>(pieces) * cost_), seconds_);
}

}  // namespace bip::rt
