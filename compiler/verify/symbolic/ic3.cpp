// See ic3.hpp. The procedures carry the names of Eén, Mishchenko, Brayton (2011) in their comments: pdrMain,
// getBadCube, recBlockCube, solveRelative, generalize, propagateBlockedCubes, addBlockedCube, isBlocked, isInitial.
//
// Frames are delta encoded: `frames_[k]` holds the cubes whose clauses hold in F_1 … F_k and in no later frame, so F_k
// is the conjunction of the clauses of frames_[k], frames_[k + 1], … and F_k implies F_{k+1} syntactically. One solver
// holds the next-state functions and all frames, each clause behind its frame's activation literal.
//
// Departures from the paper:
//   - Predecessors are lifted by an unsatisfiable core of a second solver (Chockler, Ivrii, Matsliah, Moran, Nevo:
//     Incremental Formal Verification of Hardware, 2011), not by ternary simulation: guards are arithmetic.
//   - Places of an automaton are one-hot. A cube names the marked place and never the unmarked ones, so dropping one
//     literal drops the place.
//   - Structural invariants (traps, place invariants, ranges) strengthen every frame, F_0 included.
//   - There is no frame F_infinity; lemmas that hold for ever travel with propagation.
//   - Bits that are not followed are inputs, which the invariants constrain.
#include "compiler/verify/symbolic/ic3.hpp"

#include <algorithm>
#include <queue>

#include "compiler/base/log.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class Ic3 {
 public:
  explicit Ic3(const Ic3Problem& problem)
      : problem_(problem), system_(*problem.system), cnf_(system_.aig, solver_), lift_cnf_(system_.aig, lift_solver_) {}

  /// pdrMain: block all bad states of the last frame, open a new frame, propagate; until two frames agree.
  Ic3Answer run() {
    if (problem_.bad == kFalse) {
      answer_.end = Ic3End::Safe;
      return std::move(answer_);
    }
    encode();
    while (true) {
      // Blocking phase: while the last frame F_N meets a bad state, block that state (getBadCube, recBlockCube).
      while (true) {
        const Answer bad_state = find_bad_state();
        if (bad_state == Answer::Unknown) return std::move(answer_);
        if (bad_state == Answer::Unsatisfiable) break;
        const u32 obligation = static_cast<u32>(obligations_.size());
        Cube bad_cube = lifted_bad_cube();
        obligations_.push_back({std::move(bad_cube), last_frame(), kNoRow, chosen_step(), {}, environment_});
        if (last_frame() == 0 || meets_initial(obligations_[obligation].cube, system_))
          return counterexample(obligation);
        const std::optional<u32> first = block_cube(obligation);
        if (is_stopped_) return std::move(answer_);
        if (first) return counterexample(*first);
      }
      BIP_LOG(Ic3, 1, "frame {} has no bad state: {} lemmas, {} queries, {} obligations", last_frame(), lemma_count(),
              query_count_, obligations_.size());
      // Propagation phase: a new frame, and every lemma as far up as it holds.
      add_frame();
      if (!propagate_lemmas()) return std::move(answer_);
      BIP_ASSERT(frames_are_well_formed(), "after propagation to frame {}", last_frame());
      BIP_ASSERT(answer_.end != Ic3End::Safe || is_inductive(answer_.lemmas),
                 "{} lemmas of frame {} do not prove the property", answer_.lemmas.size(), answer_.frames);
      if (answer_.end == Ic3End::Safe) return std::move(answer_);
    }
  }

 private:
  /// A cube that must be shown unreachable within `frame` steps; it leads to the bad states by `step` and then `next`.
  struct ProofObligation {
    Cube cube;
    u32 frame = 0;
    u32 next = kNoRow;                // the obligation that `step` leads to
    u32 step = kNoRow;                // row of TransitionSystem::steps
    std::vector<Signal> inputs = {};  // that are 1 in this step; only for observed signals
    Cube environment = {};            // of the bits that are not followed, in this state
  };

  [[nodiscard]] u32 last_frame() const { return static_cast<u32>(frames_.size()) - 1; }

  // Encodes the cone of influence of the bad states in both solvers, and the initial states as frame F_0.
  void encode() {
    std::vector<Signal> roots = problem_.observed;
    roots.push_back(problem_.bad);
    const ConeOfInfluence cone = cone_of_influence(system_, roots, problem_.followed);
    for (u32 bit = 0; bit < system_.bits.size(); ++bit) {
      if (cone.bits[bit] != 0) bits_.push_back(bit);
    }
    now_.assign(system_.bits.size(), 0);
    next_.assign(system_.bits.size(), 0);
    lift_now_.assign(system_.bits.size(), 0);
    lift_next_.assign(system_.bits.size(), 0);
    for (u32 bit : bits_) {
      now_[bit] = cnf_.literal(system_.bits[bit].now);
      lift_now_[bit] = lift_cnf_.literal(system_.bits[bit].now);
      next_[bit] = cnf_.literal(system_.bits[bit].next);
      lift_next_[bit] = lift_cnf_.literal(system_.bits[bit].next);
    }
    bad_ = cnf_.literal(problem_.bad);
    lift_bad_ = lift_cnf_.literal(problem_.bad);
    encode_transitions(cone);
    encode_one_hot_places(cone);
    encode_invariants(cone);
    if (!problem_.followed.empty()) encode_environment_places(cone);
    // The lifting query fixes all other inputs to their values in the model.
    for (u32 node = 1; node < system_.aig.size(); ++node) {
      const Signal input = node << 1;
      if (!system_.aig.is_input(node) || lift_cnf_.encoded(input) == 0 || cnf_.encoded(input) == 0) continue;
      free_inputs_.push_back(input);
    }
    for (u32 bit : bits_) std::erase(free_inputs_, system_.bits[bit].now);
    for (u32 bit = 0; bit < system_.bits.size() && !problem_.followed.empty(); ++bit) {
      const bool is_input = cnf_.encoded(system_.bits[bit].now) != 0 && lift_cnf_.encoded(system_.bits[bit].now) != 0;
      if (cone.bits[bit] == 0 && is_input) environment_bits_.push_back(bit);
    }
    find_traced_inputs();
    add_frame();
    for (u32 bit : bits_) {
      const std::int8_t initial = system_.bits[bit].initial;
      if (initial >= 0) solver_.add({-activation_[0], initial != 0 ? now_[bit] : -now_[bit]});
    }
  }

  // All inputs of the step that observed signals and the next state depend on.
  void find_traced_inputs() {
    if (problem_.observed.empty()) return;
    for (const Signal signal : problem_.observed) (void)cnf_.literal(signal);
    std::vector<std::uint8_t> is_bit(system_.aig.size(), 0);
    for (const u32 bit : bits_) is_bit[node_of(system_.bits[bit].now)] = 1;
    for (u32 node = 1; node < system_.aig.size(); ++node) {
      const Signal input = node << 1;
      if (system_.aig.is_input(node) && is_bit[node] == 0 && cnf_.encoded(input) != 0) traced_inputs_.push_back(input);
    }
  }
  [[nodiscard]] std::vector<Signal> inputs_of_model() const {
    std::vector<Signal> inputs;
    for (const Signal input : traced_inputs_) {
      if (solver_.is_true(cnf_.encoded(input))) inputs.push_back(input);
    }
    return inputs;
  }

  // The transition relation: exactly one chosen step, which is possible and ends in no fault. Bad states are also asked
  // for without a step, so all this stands behind an activation literal.
  void encode_transitions(const ConeOfInfluence& cone) {
    transition_activation_ = solver_.new_variable();
    if (problem_.constraint != kTrue) {
      solver_.add({-transition_activation_, cnf_.literal(problem_.constraint)});
      lift_constraint_ = lift_cnf_.literal(problem_.constraint);
    }
    std::vector<Lit> chosen, lift_chosen;
    bool all_relevant = true;
    for (u32 row = 0; row < system_.steps.size(); ++row) {
      if (cone.steps[row] == 0) {
        all_relevant = false;
        continue;
      }
      steps_.push_back(row);
      chosen.push_back(cnf_.literal(system_.steps[row].chosen));
      lift_chosen.push_back(lift_cnf_.literal(system_.steps[row].chosen));
      solver_.add({-transition_activation_, -chosen.back(), cnf_.literal(system_.steps[row].fine)});
      (void)lift_cnf_.literal(system_.steps[row].fine);
    }
    BIP_ASSERT(steps_.size() == chosen.size() && chosen.size() == lift_chosen.size(), "{} literals of {} steps",
               chosen.size(), steps_.size());
    add_at_most_one(solver_, chosen);
    add_at_most_one(lift_solver_, lift_chosen);
    // Steps outside of the cone stutter, so "no step of the cone" is a step unless the cone has all of them.
    if (all_relevant) {
      chosen.push_back(-transition_activation_);
      solver_.add(chosen);
    }
  }

  void encode_one_hot_places(const ConeOfInfluence& cone) {
    for (const std::vector<u32>& group : system_.exactly_one) {
      if (cone.bits[group[0]] == 0) continue;
      std::vector<Lit> places, lift_places;
      for (u32 bit : group) {
        places.push_back(now_[bit]);
        lift_places.push_back(lift_now_[bit]);
      }
      solver_.add(places);
      add_at_most_one(solver_, places);
      lift_solver_.add(lift_places);
      add_at_most_one(lift_solver_, lift_places);
    }
  }

  // The same of automata that are not followed, as far as steps and invariants depend on them.
  void encode_environment_places(const ConeOfInfluence& cone) {
    for (const std::vector<u32>& group : system_.exactly_one) {
      const auto is_encoded = [&](u32 bit) { return cnf_.encoded(system_.bits[bit].now) != 0; };
      if (cone.bits[group[0]] != 0 || std::none_of(group.begin(), group.end(), is_encoded)) continue;
      std::vector<Lit> places;
      for (u32 bit : group) places.push_back(cnf_.literal(system_.bits[bit].now));
      solver_.add(places);
      add_at_most_one(solver_, places);
    }
  }

  // By node: is an input below it encoded?
  [[nodiscard]] std::vector<std::uint8_t> nodes_above_encoded() const {
    const Aig& aig = system_.aig;
    std::vector<std::uint8_t> is_above(aig.size(), 0);
    for (u32 node = 1; node < aig.size(); ++node) {
      const auto [a, b] = aig.node(node);
      is_above[node] = aig.is_input(node) ? static_cast<std::uint8_t>(cnf_.encoded(node << 1) != 0)
                                          : is_above[node_of(a)] | is_above[node_of(b)];
    }
    return is_above;
  }

  // Invariants hold in every reachable state, so every frame may assume them. One that leaves the cone is left out:
  // that only weakens the frames. Where bits are not followed, those that say something of the cone are kept: they are
  // what is known of its environment.
  void encode_invariants(const ConeOfInfluence& cone) {
    const bool is_local = !problem_.followed.empty();
    const std::vector<std::uint8_t> covered = is_local ? nodes_above_encoded() : nodes_in_cone(system_, cone);
    const auto add_invariant = [&](const std::vector<Signal>& clause) {
      const auto is_covered = [&](Signal s) { return covered[node_of(s)] != 0; };
      if (is_local ? std::none_of(clause.begin(), clause.end(), is_covered)
                   : !std::all_of(clause.begin(), clause.end(), is_covered))
        return;
      std::vector<Lit> literals;
      for (Signal s : clause) literals.push_back(cnf_.literal(s));
      solver_.add(literals);
      // What is known of all states is no reason for a step, so lifting need not give it.
      if (is_local && clause.size() == 1 && lift_cnf_.encoded(clause[0]) != 0)
        lift_solver_.add({lift_cnf_.encoded(clause[0])});
    };
    for (const std::vector<Signal>& clause : problem_.invariants) add_invariant(clause);
    for (Signal inside : system_.in_range) add_invariant({inside});
  }

  void add_frame() {
    BIP_ASSERT(frames_.size() == activation_.size(), "{} frames, {} activation literals", frames_.size(),
               activation_.size());
    frames_.emplace_back();
    activation_.push_back(solver_.new_variable());
  }
  // Assumes F_k: by the delta encoding the clauses of frame k and of all later frames. F_0 is the initial states.
  void assume_frame(u32 frame) {
    if (frame != 0) solver_.assume(-activation_[0]);
    for (u32 k = frame; k < frames_.size(); ++k) solver_.assume(activation_[k]);
  }
  [[nodiscard]] static Lit literal_of(const std::vector<Lit>& variables, u32 cube_literal) {
    const Lit variable = variables[cube_bit(cube_literal)];
    return cube_value(cube_literal) ? variable : -variable;
  }

  // Is F_N and bad satisfiable? A bad state may have no step at all, and a bad step is one that is chosen: the
  // transition relation is off.
  Answer find_bad_state() {
    assume_frame(last_frame());
    solver_.assume(bad_);
    solver_.assume(-transition_activation_);
    return solver_.solve(problem_.cancellation);
  }

  [[nodiscard]] u32 chosen_step() const {
    for (u32 step : steps_) {
      if (solver_.is_true(cnf_.encoded(system_.steps[step].chosen))) return step;
    }
    return kNoRow;
  }

  // The state of the model as a cube over the cone; unmarked places of automata follow from the marked one.
  [[nodiscard]] Cube state_cube() const {
    Cube cube;
    for (u32 bit : bits_) {
      const bool value = solver_.is_true(now_[bit]);
      if (!value && system_.bits[bit].is_alone) continue;
      cube.push_back(cube_literal_of(bit, value));
    }
    return cube;
  }

  // Lifting (Chockler et al. 2011): with the inputs of the model, the state contradicts the clause `target_fails`; the
  // core of that contradiction is the part of the state that forces the target whatever the other bits are.
  Cube lift(const std::vector<Lit>& target_fails) {
    const Cube state = state_cube();
    const Lit activation = lift_solver_.new_variable();
    std::vector<Lit> clause = target_fails;
    clause.push_back(-activation);
    lift_solver_.add(clause);
    lift_solver_.assume(activation);
    for (Signal input : free_inputs_) {
      const Lit value = lift_cnf_.encoded(input);
      lift_solver_.assume(solver_.is_true(cnf_.encoded(input)) ? value : -value);
    }
    for (u32 cube_literal : state) lift_solver_.assume(literal_of(lift_now_, cube_literal));
    Cube cube;
    environment_.clear();
    if (lift_solver_.solve(problem_.cancellation) == Answer::Unsatisfiable) {
      for (u32 cube_literal : state) {
        if (lift_solver_.is_needed(literal_of(lift_now_, cube_literal))) cube.push_back(cube_literal);
      }
      for (u32 bit : environment_bits_) {
        const bool value = solver_.is_true(cnf_.encoded(system_.bits[bit].now));
        const Lit positive = lift_cnf_.encoded(system_.bits[bit].now);
        if (lift_solver_.is_needed(value ? positive : -positive)) environment_.push_back(cube_literal_of(bit, value));
      }
    } else {
      // Out of time, or the state needs what the lifting solver does not know: the whole state is a cube, too.
      cube = state;
    }
    lift_solver_.add({-activation});
    BIP_ASSERT(is_cube(cube), "a lifted cube of {} literals", cube.size());
    return cube;
  }
  Cube lifted_bad_cube() { return lift({-lift_bad_}); }
  Cube lifted_predecessor(const Cube& successor, u32 step) {
    std::vector<Lit> target_fails;
    for (u32 cube_literal : successor) target_fails.push_back(-literal_of(lift_next_, cube_literal));
    if (step != kNoRow) target_fails.push_back(-lift_cnf_.literal(system_.steps[step].fine));
    if (lift_constraint_ != 0) target_fails.push_back(-lift_constraint_);
    return lift(target_fails);
  }

  // solveRelative: is F_{frame-1} ∧ ¬cube ∧ T ∧ cube' satisfiable? If not, `core` gets the literals of cube' in the
  // solver's core, which is blocked in `frame` as well; it still excludes the initial states.
  Answer solve_relative(const Cube& cube, u32 frame, Cube* core) {
    BIP_ASSERT(frame >= 1 && frame <= last_frame(), "frame {} of {}", frame, last_frame());
    BIP_ASSERT(!meets_initial(cube, system_), "a cube of {} literals meets the initial states", cube.size());
    if (++query_count_ % 64 == 0 && problem_.report) problem_.report(last_frame(), lemma_count());
    // ¬cube is needed for this query only.
    const Lit activation = solver_.new_variable();
    std::vector<Lit> not_cube{-activation};
    for (u32 cube_literal : cube) not_cube.push_back(-literal_of(now_, cube_literal));
    solver_.add(not_cube);
    assume_frame(frame - 1);
    solver_.assume(transition_activation_);
    solver_.assume(activation);
    for (u32 cube_literal : cube) solver_.assume(literal_of(next_, cube_literal));
    const Answer answer = solver_.solve(problem_.cancellation);
    if (answer == Answer::Unsatisfiable && core != nullptr) {
      core->clear();
      for (u32 cube_literal : cube) {
        if (solver_.is_needed(literal_of(next_, cube_literal))) core->push_back(cube_literal);
      }
      if (meets_initial(*core, system_)) exclude_initial(cube, *core);
    }
    // A satisfied query's clause stays until its model has been read.
    if (answer != Answer::Satisfiable) solver_.add({-activation});
    else stale_activations_.push_back(activation);
    return answer;
  }
  // Restores a literal of the cube that excludes the initial states.
  void exclude_initial(const Cube& cube, Cube& core) const {
    for (u32 cube_literal : cube) {
      const std::int8_t initial = system_.bits[cube_bit(cube_literal)].initial;
      if (initial < 0 || (initial != 0) == cube_value(cube_literal)) continue;
      core.push_back(cube_literal);
      break;
    }
    std::sort(core.begin(), core.end());
    BIP_ASSERT(!meets_initial(core, system_) && subsumes(core, cube), "a core of {} literals meets the initial states",
               core.size());
  }
  void retire_query_clauses() {
    for (Lit activation : stale_activations_) solver_.add({-activation});
    stale_activations_.clear();
  }
  [[nodiscard]] std::size_t lemma_count() const {
    std::size_t count = 0;
    for (const std::vector<Cube>& frame : frames_) count += frame.size();
    return count;
  }

  // isBlocked: does a lemma of F_frame subsume the cube's clause?
  [[nodiscard]] bool is_blocked(const Cube& cube, u32 frame) const {
    for (u32 k = frame; k < frames_.size(); ++k) {
      for (const Cube& lemma : frames_[k]) {
        if (subsumes(lemma, cube)) return true;
      }
    }
    return false;
  }
  // Cubes are sorted. A smaller cube covers more states.
  [[nodiscard]] static bool subsumes(const Cube& smaller, const Cube& larger) {
    return std::includes(larger.begin(), larger.end(), smaller.begin(), smaller.end());
  }

  // addBlockedCube: removes what the new lemma subsumes in F_1 … F_frame, then adds it to frame `frame`.
  void add_blocked_cube(const Cube& cube, u32 frame) {
    BIP_ASSERT(frame >= 1 && frame <= last_frame(), "frame {} of {}", frame, last_frame());
    BIP_ASSERT(is_cube(cube) && !meets_initial(cube, system_), "a lemma of {} literals in frame {}", cube.size(),
               frame);
    for (u32 k = 1; k <= frame; ++k) std::erase_if(frames_[k], [&](const Cube& old) { return subsumes(cube, old); });
    frames_[frame].push_back(cube);
    std::vector<Lit> clause{-activation_[frame]};
    for (u32 cube_literal : cube) clause.push_back(-literal_of(now_, cube_literal));
    solver_.add(clause);
    BIP_LOG(Ic3, 3, "lemma of {} literals in frame {}", cube.size(), frame);
  }

  // generalize: drops one literal after the other as long as the smaller cube is still inductive relative to
  // F_{frame-1}, and takes the core each time. False: out of time.
  bool generalise(Cube& cube, u32 frame) {
    for (std::size_t k = cube.size(); k-- > 0 && cube.size() > 1;) {
      if (k >= cube.size()) continue;
      Cube smaller = cube;
      smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
      if (meets_initial(smaller, system_)) continue;
      Cube core;
      const Answer answer = solve_relative(smaller, frame, &core);
      retire_query_clauses();
      if (answer == Answer::Unknown) return false;
      if (answer == Answer::Unsatisfiable) cube = std::move(core);
    }
    return true;
  }

  // recBlockCube: takes proof obligations from the queue, the lowest frame first. Nothing: the cube is blocked (or the
  // time is over, is_stopped_). Otherwise the obligation that holds an initial state, where a counterexample begins.
  std::optional<u32> block_cube(u32 obligation) {
    using Entry = std::pair<u32, u32>;  // frame, obligation
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    queue.emplace(obligations_[obligation].frame, obligation);
    while (!queue.empty()) {
      const auto [frame, current] = queue.top();
      queue.pop();
      // Already blocked by a lemma found meanwhile: go on in the next frame, so that long counterexamples are found.
      if (is_blocked(obligations_[current].cube, frame)) {
        if (frame < last_frame()) queue.emplace(frame + 1, current);
        continue;
      }
      Cube core;
      const Answer answer = solve_relative(obligations_[current].cube, frame, &core);
      if (answer == Answer::Unknown) {
        is_stopped_ = true;
        return std::nullopt;
      }
      if (answer == Answer::Satisfiable) {
        // A predecessor in F_{frame-1}: a new obligation one frame below, and this one again after it.
        const u32 step = chosen_step();
        Cube cube = lifted_predecessor(obligations_[current].cube, step);
        ProofObligation predecessor{std::move(cube), frame - 1, current, step, inputs_of_model(), environment_};
        retire_query_clauses();
        const bool is_first = frame == 1 || meets_initial(predecessor.cube, system_);
        obligations_.push_back(std::move(predecessor));
        const u32 added = static_cast<u32>(obligations_.size()) - 1;
        if (is_first) return added;
        BIP_ASSERT(frame >= 2 && obligations_[added].next == current, "obligation {} in frame {}", added, frame);
        queue.emplace(frame - 1, added);
        queue.emplace(frame, current);
        continue;
      }
      // Blocked: generalise, then find the last frame in which the lemma still is inductive.
      u32 lemma_frame = frame;
      if (!generalise(core, frame)) {
        is_stopped_ = true;
        return std::nullopt;
      }
      while (lemma_frame < last_frame()) {
        const Answer in_next = solve_relative(core, lemma_frame + 1, nullptr);
        retire_query_clauses();
        if (in_next != Answer::Unsatisfiable) break;
        ++lemma_frame;
      }
      add_blocked_cube(core, lemma_frame);
      if (lemma_frame < last_frame()) queue.emplace(lemma_frame + 1, current);
    }
    return std::nullopt;
  }

  // propagateBlockedCubes: moves each lemma to the next frame if it is inductive there. An empty delta means
  // F_k = F_{k+1}, an inductive invariant. False: out of time.
  bool propagate_lemmas() {
    for (u32 frame = 1; frame < last_frame(); ++frame) {
      const std::vector<Cube> lemmas = frames_[frame];
      for (const Cube& cube : lemmas) {
        Cube core;
        const Answer answer = solve_relative(cube, frame + 1, &core);
        retire_query_clauses();
        if (answer == Answer::Unknown) return false;
        if (answer == Answer::Unsatisfiable) {
          std::erase(frames_[frame], cube);
          add_blocked_cube(core, frame + 1);
        }
      }
      if (frames_[frame].empty()) {
        answer_.end = Ic3End::Safe;
        answer_.frames = last_frame();
        for (u32 k = frame + 1; k < frames_.size(); ++k)
          answer_.lemmas.insert(answer_.lemmas.end(), frames_[k].begin(), frames_[k].end());
        BIP_LOG(Ic3, 1, "frames {} and {} agree: {} lemmas", frame, frame + 1, answer_.lemmas.size());
        return true;
      }
    }
    return true;
  }

  // Follows the obligations from an initial state to the bad one.
  Ic3Answer counterexample(u32 first) {
    answer_.end = Ic3End::Reached;
    answer_.frames = last_frame();
    u32 obligation = first;
    if (!problem_.observed.empty()) answer_.first = obligations_[first].cube;
    for (u32 state = first; !problem_.followed.empty() && state != kNoRow; state = obligations_[state].next) {
      Cube& cube = answer_.required.emplace_back(obligations_[state].cube);
      cube.insert(cube.end(), obligations_[state].environment.begin(), obligations_[state].environment.end());
      std::sort(cube.begin(), cube.end());
    }
    for (; obligations_[obligation].next != kNoRow; obligation = obligations_[obligation].next) {
      answer_.steps.push_back(obligations_[obligation].step);
      if (!problem_.observed.empty()) answer_.inputs.push_back(std::move(obligations_[obligation].inputs));
    }
    answer_.bad_step = obligations_[obligation].step;
    BIP_LOG(Ic3, 1, "a bad state is reached in {} steps, {} frames", answer_.steps.size(), answer_.frames);
    return std::move(answer_);
  }

  // ---- what the assertions check
  [[nodiscard]] bool is_cube(const Cube& cube) const {
    for (std::size_t k = 0; k < cube.size(); ++k) {
      if (cube_bit(cube[k]) >= system_.bits.size() || now_[cube_bit(cube[k])] == 0) return false;
      if (k > 0 && cube_bit(cube[k - 1]) >= cube_bit(cube[k])) return false;
    }
    return true;
  }
  // Proves the result again without the frames: the lemmas exclude the initial states' successors that they should,
  // each holds after a step from where all hold, and where all hold nothing is bad. Out of time: true.
  [[nodiscard]] bool is_inductive(const std::vector<Cube>& lemmas) {
    const Lit all_hold = solver_.new_variable();
    for (const Cube& cube : lemmas) {
      if (meets_initial(cube, system_)) return false;
      std::vector<Lit> clause{-all_hold};
      for (u32 cube_literal : cube) clause.push_back(-literal_of(now_, cube_literal));
      solver_.add(clause);
    }
    bool is_sound = true;
    for (std::size_t k = 0; k <= lemmas.size() && is_sound; ++k) {
      solver_.assume(all_hold);
      solver_.assume(k < lemmas.size() ? transition_activation_ : -transition_activation_);
      if (k == lemmas.size()) solver_.assume(bad_);
      for (std::size_t i = 0; k < lemmas.size() && i < lemmas[k].size(); ++i)
        solver_.assume(literal_of(next_, lemmas[k][i]));
      is_sound = solver_.solve(problem_.cancellation) != Answer::Satisfiable;
    }
    solver_.add({-all_hold});
    return is_sound;
  }
  // F_0 has no lemmas (it is the initial states, which every lemma excludes), so that F_k implies F_{k+1} for all k;
  // no lemma of a frame stands twice, in the frame or in a later one.
  [[nodiscard]] bool frames_are_well_formed() const {
    if (!frames_[0].empty()) return false;
    for (u32 frame = 1; frame < frames_.size(); ++frame) {
      for (const Cube& cube : frames_[frame]) {
        if (!is_cube(cube) || meets_initial(cube, system_)) return false;
        if (std::count(frames_[frame].begin(), frames_[frame].end(), cube) != 1) return false;
      }
    }
    return true;
  }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  Solver solver_{SolverStyle::Plain}, lift_solver_{SolverStyle::Plain};
  Cnf cnf_, lift_cnf_;
  Ic3Answer answer_;
  std::vector<u32> bits_, steps_;                       // rows in the cone of influence
  std::vector<Lit> now_, next_, lift_now_, lift_next_;  // by bit; 0 outside of the cone
  Lit bad_ = 0, lift_bad_ = 0;
  Lit lift_constraint_ = 0;                // 0: none
  Lit transition_activation_ = 0;          // the transition relation holds
  std::vector<Signal> free_inputs_;        // inputs that are no state bits, and bits that are not followed
  std::vector<u32> environment_bits_;      // the latter, by row
  Cube environment_;                       // of them, what the last lifting needed
  std::vector<Signal> traced_inputs_;      // the same, and those of observed signals
  std::vector<std::vector<Cube>> frames_;  // delta encoded: a lemma stands in the last frame in which it holds
  std::vector<Lit> activation_;            // by frame; 0: the initial states
  std::vector<Lit> stale_activations_;     // of clauses of satisfied queries
  std::vector<ProofObligation> obligations_;
  std::uint64_t query_count_ = 0;
  bool is_stopped_ = false;
};

}  // namespace

Ic3Answer run_ic3(const Ic3Problem& problem) { return Ic3(problem).run(); }

bool meets_initial(const Cube& cube, const TransitionSystem& system) {
  return std::none_of(cube.begin(), cube.end(), [&](u32 cube_literal) {
    const std::int8_t initial = system.bits[cube_bit(cube_literal)].initial;
    return initial >= 0 && (initial != 0) != cube_value(cube_literal);
  });
}

}  // namespace bip::verify
