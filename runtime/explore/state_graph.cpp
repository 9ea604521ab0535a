// See state_graph.hpp. A batch of states is expanded first, then all successors are added to the store at once, whose
// look-ups share their waiting for memory.
#include "runtime/explore/state_graph.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/explore/follow_path.hpp"

namespace bip::rt {

namespace {

constexpr u32 kStatesPerBatch = 1024;
constexpr u32 kStatesPerPoll = 64;  // where the core is asked, a state can take milliseconds

}  // namespace

StateGraph::StateGraph(const Image& image, GraphOptions options) : image_(image), options_(std::move(options)) {
  BIP_ASSERT(options_.predicates.size() <= 64, "{} predicates", options_.predicates.size());
}

bool StateGraph::initialize() {
  Core core(image_, {.progress = options_.progress});
  if (!begins(core)) return false;
  space_.image = &image_;
  space_.progress = options_.progress;
  space_.shapes = shapes_of(core, options_.progress);
  space_.locals = std::make_unique<Locals>(core, options_.unread_cells);
  space_.initial = core.snapshot();
  space_.labels = &labels_;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) (void)space_.locals->number(atom, core);
  space_.layout = Layout(*space_.locals);
  store_ = std::make_unique<StateStore>(space_.layout.words(), options_.bytes);
  expander_ = std::make_unique<Expander>(space_, 1);
  predicate_options_.reserve(options_.predicates.size());
  for (const GraphPredicate& predicate : options_.predicates) {
    ExploreOptions& options = predicate_options_.emplace_back();
    options.predicate = predicate.holds;
    options.predicate_connectors = predicate.connectors;
    options.predicate_reads = predicate.atoms;
    evaluators_.emplace_back(space_, options);
  }
  out_.words.resize(1);
  first_.assign(1, 0);
  state_.resize(space_.layout.words());
  (void)expander_->pack(core, state_.data());
  return store_->add(state_.data(), 1);
}

std::size_t StateGraph::bytes() const {
  std::size_t sum = space_.locals->bytes() + store_->bytes() + expander_->bytes();
  for (const PredicateEvaluator& evaluator : evaluators_) sum += evaluator.bytes();
  sum += first_.capacity() * sizeof(u64) + is_end_.capacity() + values_.capacity() * sizeof(u32);
  return sum + (targets_.capacity() + labels_of_steps_.capacity()) * sizeof(u32);
}

u32 StateGraph::value_in(const u64* state) {
  u64 bits = 0;
  for (std::size_t k = 0; k < evaluators_.size(); ++k) {
    if (evaluators_[k].holds(state, *expander_)) bits |= u64{1} << k;
  }
  // Neighbours mostly agree.
  if (!batch_values_.empty() && valuations_[batch_values_.back()] == bits) return batch_values_.back();
  const auto [at, is_new] = row_of_valuation_.try_emplace(bits, static_cast<u32>(valuations_.size()));
  if (is_new) valuations_.push_back(bits);
  return at->second;
}

// Every state anew in a wider layout, in the same order.
bool StateGraph::widen() {
  const Layout before = space_.layout;
  const std::unique_ptr<StateStore> old = std::move(store_);
  space_.layout = Layout(*space_.locals);
  store_ = std::make_unique<StateStore>(space_.layout.words(), options_.bytes);
  expander_->relayout();
  for (PredicateEvaluator& evaluator : evaluators_) evaluator.relayout();
  std::vector<u64> from(before.words()), to(space_.layout.words());
  for (u32 row = 0; row < old->size(); ++row) {
    old->read(row, from.data(), read_scratch_);
    std::fill(to.begin(), to.end(), u64{0});
    for (u32 atom = 0; atom < space_.locals->atoms(); ++atom)
      space_.layout.set(to.data(), atom, before.get(from.data(), atom));
    if (!store_->add(to.data(), 1)) return false;
  }
  BIP_ASSERT(old->size() == store_->size(), "{} states of {}", store_->size(), old->size());
  state_.resize(space_.layout.words());
  return true;
}

// Expands states [expanded(), end). Nothing of a batch counts if a number did not fit.
ExploreEnd StateGraph::expand_batch(u32 end) {
  out_.clear();
  counts_.clear();
  batch_values_.clear();
  batch_ends_.clear();
  u64 deadlocks = 0, errors = 0;
  for (u32 row = expanded(); row < end; ++row) {
    if ((row + 1) % kStatesPerPoll == 0 && options_.is_stopped && options_.is_stopped()) return ExploreEnd::Stopped;
    store_->read(row, state_.data(), read_scratch_);
    const std::size_t before = out_.labels.size();
    const Expander::Result result = expander_->expand(state_.data(), out_);
    if (expander_->is_too_narrow()) {
      const bool has_room = options_.bytes == 0 || bytes() + store_->bytes() <= options_.bytes;
      return has_room && widen() ? ExploreEnd::Complete : ExploreEnd::Memory;
    }
    counts_.push_back(static_cast<u32>(out_.labels.size() - before));
    batch_values_.push_back(value_in(state_.data()));
    batch_ends_.push_back(result.is_deadlock || result.is_final ? 1 : 0);
    deadlocks += result.is_deadlock ? 1 : 0;
    errors += result.has_error ? 1 : 0;
  }
  rows_.resize(out_.labels.size());
  BIP_ASSERT(out_.words[0].size() == rows_.size() * space_.layout.words(), "{} labels", rows_.size());
  if (!store_->add(out_.words[0].data(), rows_.size(), nullptr, rows_.data())) return ExploreEnd::Memory;
  targets_.insert(targets_.end(), rows_.begin(), rows_.end());
  labels_of_steps_.insert(labels_of_steps_.end(), out_.labels.begin(), out_.labels.end());
  for (const u32 count : counts_) first_.push_back(first_.back() + count);
  is_end_.insert(is_end_.end(), batch_ends_.begin(), batch_ends_.end());
  values_.insert(values_.end(), batch_values_.begin(), batch_values_.end());
  deadlocks_ += deadlocks;
  errors_ += errors;
  return ExploreEnd::Complete;
}

ExploreEnd StateGraph::grow(u32 wanted) {
  while (!is_complete() && expanded() < wanted) {
    const u32 end = static_cast<u32>(std::min<u64>(u64{expanded()} + kStatesPerBatch, std::min(wanted, states())));
    const ExploreEnd ended = expand_batch(end);
    if (ended != ExploreEnd::Complete) return ended;
    if (options_.bytes != 0 && bytes() > options_.bytes) return ExploreEnd::Memory;
    if (options_.is_stopped && options_.is_stopped()) return ExploreEnd::Stopped;
  }
  return ExploreEnd::Complete;
}

void StateGraph::each_state(const std::function<void(const Core&)>& visit) {
  for (u32 row = 0; row < states(); ++row) {
    store_->read(row, state_.data(), read_scratch_);
    const bool is_entered = expander_->enter(expander_->core(), state_.data());
    BIP_ASSERT(is_entered, "state {} cannot be entered again", row);
    visit(expander_->core());
  }
}

u32 StateGraph::find(const Core& core) {
  std::vector<u64> packed(space_.layout.words());
  return expander_->pack(core, packed.data()) ? store_->find(packed.data()) : kNone;
}

}  // namespace bip::rt
