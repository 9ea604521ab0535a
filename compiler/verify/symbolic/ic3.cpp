// See ic3.hpp. One solver has the machine's next-state functions and all frames, switched on by a literal each; a
// second one shrinks predecessors to what matters. Cubes name the marked place of an automaton, never its unmarked
// ones.
#include "compiler/verify/symbolic/ic3.hpp"

#include <algorithm>
#include <queue>

#include "compiler/verify/symbolic/cnf.hpp"

namespace bip::verify {

namespace {

class Pdr {
 public:
  explicit Pdr(const Ic3Problem& problem)
      : p_(problem), m_(*problem.machine), cnf_(m_.circuit, main_), lift_cnf_(m_.circuit, lift_) {}

  Ic3Answer run() {
    if (p_.bad == kFalse) {
      answer_.end = Ic3End::Safe;
      return std::move(answer_);
    }
    prepare();
    while (true) {
      // Bad states that the last frame allows.
      while (true) {
        const Answer found = ask_bad();
        if (found == Answer::Unknown) return std::move(answer_);
        if (found == Answer::Unsatisfiable) break;
        const std::uint32_t top = static_cast<u32>(obligations_.size());
        obligations_.push_back({bad_cube(), top_frame(), kNoRow, chosen_step()});
        if (top_frame() == 0 || meets_initial(obligations_[top].cube, m_)) return reached(top);
        const std::optional<u32> first = block(top);
        if (is_stopped_) return std::move(answer_);
        if (first) return reached(*first);
      }
      add_frame();
      if (!push()) return std::move(answer_);
      if (answer_.end == Ic3End::Safe) return std::move(answer_);
    }
  }

 private:
  struct Obligation {
    Cube cube;
    u32 frame = 0;
    u32 next = kNoRow;  // the obligation that its step leads to
    u32 step = kNoRow;  // row of TransitionSystem::steps
  };

  [[nodiscard]] u32 top_frame() const { return static_cast<u32>(frames_.size()) - 1; }

  void prepare() {
    std::vector<Signal> signals{p_.bad};
    const ConeOfInfluence relevant = cone_of_influence(m_, signals);
    for (u32 row = 0; row < m_.bits.size(); ++row) {
      if (relevant.bits[row] != 0) bits_.push_back(row);
    }
    now_.assign(m_.bits.size(), 0);
    next_.assign(m_.bits.size(), 0);
    lift_now_.assign(m_.bits.size(), 0);
    lift_next_.assign(m_.bits.size(), 0);
    for (u32 row : bits_) {
      now_[row] = cnf_.literal(m_.bits[row].now);
      lift_now_[row] = lift_cnf_.literal(m_.bits[row].now);
      next_[row] = cnf_.literal(m_.bits[row].next);
      lift_next_[row] = lift_cnf_.literal(m_.bits[row].next);
    }
    bad_ = cnf_.literal(p_.bad);
    lift_bad_ = lift_cnf_.literal(p_.bad);
    // What a step needs, switched on where a step is meant.
    going_ = main_.new_variable();
    std::vector<Lit> chosen, lift_chosen;
    bool all_relevant = true;
    for (u32 row = 0; row < m_.steps.size(); ++row) {
      if (relevant.steps[row] == 0) {
        all_relevant = false;
        continue;
      }
      steps_.push_back(row);
      chosen.push_back(cnf_.literal(m_.steps[row].chosen));
      lift_chosen.push_back(lift_cnf_.literal(m_.steps[row].chosen));
      main_.add({-going_, -chosen.back(), cnf_.literal(m_.steps[row].fine)});
      (void)lift_cnf_.literal(m_.steps[row].fine);
    }
    add_at_most_one(main_, chosen);
    add_at_most_one(lift_, lift_chosen);
    if (all_relevant) {
      chosen.push_back(-going_);
      main_.add(chosen);
    }
    for (const std::vector<u32>& group : m_.exactly_one) {
      if (relevant.bits[group[0]] == 0) continue;
      std::vector<Lit> here, there;
      for (u32 row : group) {
        here.push_back(now_[row]);
        there.push_back(lift_now_[row]);
      }
      main_.add(here);
      add_at_most_one(main_, here);
      lift_.add(there);
      add_at_most_one(lift_, there);
    }
    const std::vector<std::uint8_t> covered = nodes_in_cone(m_, relevant);
    const auto add_invariant = [&](const std::vector<Signal>& clause) {
      std::vector<Lit> literals;
      for (Signal s : clause) {
        if (covered[node_of(s)] == 0) return;
        literals.push_back(cnf_.literal(s));
      }
      main_.add(literals);
    };
    for (const std::vector<Signal>& clause : p_.invariants) add_invariant(clause);
    for (Signal inside : m_.in_range) add_invariant({inside});
    // Other inputs, for shrinking: all of them are held.
    for (u32 node = 1; node < m_.circuit.size(); ++node) {
      if (!m_.circuit.is_input(node) || lift_cnf_.known(node << 1) == 0 || cnf_.known(node << 1) == 0) continue;
      free_.push_back(node << 1);
    }
    for (u32 row : bits_) std::erase(free_, m_.bits[row].now);
    add_frame();
    for (u32 row : bits_) {
      if (m_.bits[row].initial >= 0) main_.add({-switches_[0], m_.bits[row].initial != 0 ? now_[row] : -now_[row]});
    }
  }

  void add_frame() {
    frames_.emplace_back();
    switches_.push_back(main_.new_variable());
  }
  void assume_frame(u32 frame) {
    if (frame != 0) main_.assume(-switches_[0]);
    for (u32 k = frame; k < frames_.size(); ++k) main_.assume(switches_[k]);
  }
  [[nodiscard]] Lit literal(const std::vector<Lit>& of, u32 code) const {
    return (code & 1) != 0 ? of[code / 2] : -of[code / 2];
  }

  Answer ask_bad() {
    assume_frame(top_frame());
    main_.assume(bad_);
    // A bad state may have no step at all; a bad step is one that is chosen.
    main_.assume(-going_);
    return main_.solve(p_.cancellation);
  }

  u32 chosen_step() const {
    for (u32 row : steps_) {
      if (main_.is_true(cnf_.known(m_.steps[row].chosen))) return row;
    }
    return kNoRow;
  }

  Cube whole_state() const {
    Cube cube;
    for (u32 row : bits_) {
      const bool value = main_.is_true(now_[row]);
      if (!value && m_.bits[row].is_alone) continue;
      cube.push_back(2 * row + (value ? 1 : 0));
    }
    return cube;
  }
  // The part of the state, with the inputs as they are, that already forces what the clause `open` denies.
  Cube lifted(const std::vector<Lit>& open) {
    const Cube whole = whole_state();
    const Lit here = lift_.new_variable();
    std::vector<Lit> clause = open;
    clause.push_back(-here);
    lift_.add(clause);
    lift_.assume(here);
    for (Signal s : free_) {
      const Lit value = lift_cnf_.known(s);
      lift_.assume(main_.is_true(cnf_.known(s)) ? value : -value);
    }
    for (u32 code : whole) lift_.assume(literal(lift_now_, code));
    Cube cube;
    if (lift_.solve(p_.cancellation) == Answer::Unsatisfiable) {
      for (u32 code : whole) {
        if (lift_.is_needed(literal(lift_now_, code))) cube.push_back(code);
      }
    } else {
      cube = whole;
    }
    lift_.add({-here});
    return cube;
  }
  Cube bad_cube() { return lifted({-lift_bad_}); }
  Cube predecessor(const Cube& of, u32 step) {
    std::vector<Lit> open;
    for (u32 code : of) open.push_back(-literal(lift_next_, code));
    if (step != kNoRow) open.push_back(-lift_cnf_.literal(m_.steps[step].fine));
    return lifted(open);
  }

  // Can a step lead from frame - 1, outside of the cube, into it? If not, `core` is the part of the cube that is why.
  Answer ask_into(const Cube& cube, u32 frame, Cube* core) {
    if (++questions_ % 64 == 0 && p_.report) p_.report(top_frame(), lemma_count());
    const Lit here = main_.new_variable();
    std::vector<Lit> outside{-here};
    for (u32 code : cube) outside.push_back(-literal(now_, code));
    main_.add(outside);
    assume_frame(frame - 1);
    main_.assume(going_);
    main_.assume(here);
    for (u32 code : cube) main_.assume(literal(next_, code));
    const Answer answer = main_.solve(p_.cancellation);
    if (answer == Answer::Unsatisfiable && core != nullptr) {
      core->clear();
      for (u32 code : cube) {
        if (main_.is_needed(literal(next_, code))) core->push_back(code);
      }
      if (meets_initial(*core, m_)) {
        // Something must keep the initial state out.
        for (u32 code : cube) {
          const std::int8_t initial = m_.bits[code / 2].initial;
          if (initial < 0 || initial == static_cast<std::int8_t>(code & 1)) continue;
          core->push_back(code);
          break;
        }
        std::sort(core->begin(), core->end());
      }
    }
    if (answer != Answer::Satisfiable) main_.add({-here});
    else to_drop_.push_back(here);
    return answer;
  }
  void drop_questions() {
    for (Lit here : to_drop_) main_.add({-here});
    to_drop_.clear();
  }
  [[nodiscard]] std::size_t lemma_count() const {
    std::size_t count = 0;
    for (const std::vector<Cube>& frame : frames_) count += frame.size();
    return count;
  }

  [[nodiscard]] bool is_blocked(const Cube& cube, u32 frame) const {
    for (u32 k = frame; k < frames_.size(); ++k) {
      for (const Cube& lemma : frames_[k]) {
        if (std::includes(cube.begin(), cube.end(), lemma.begin(), lemma.end())) return true;
      }
    }
    return false;
  }
  void add_lemma(const Cube& cube, u32 frame) {
    for (u32 k = 1; k <= frame; ++k) {
      std::erase_if(frames_[k],
                    [&](const Cube& old) { return std::includes(old.begin(), old.end(), cube.begin(), cube.end()); });
    }
    frames_[frame].push_back(cube);
    std::vector<Lit> clause{-switches_[frame]};
    for (u32 code : cube) clause.push_back(-literal(now_, code));
    main_.add(clause);
  }

  // Drops literals as long as the smaller cube cannot be entered either.
  bool generalise(Cube& cube, u32 frame) {
    for (std::size_t k = cube.size(); k-- > 0 && cube.size() > 1;) {
      if (k >= cube.size()) continue;
      Cube smaller = cube;
      smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
      if (meets_initial(smaller, m_)) continue;
      Cube core;
      const Answer answer = ask_into(smaller, frame, &core);
      drop_questions();
      if (answer == Answer::Unknown) return false;
      if (answer == Answer::Unsatisfiable) cube = std::move(core);
    }
    return true;
  }

  // Shows that the obligation's cube is not reached within its frame, or finds the way there: the row of its first
  // step.
  std::optional<u32> block(u32 row) {
    using Entry = std::pair<u32, u32>;  // frame, obligation
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> todo;
    todo.emplace(obligations_[row].frame, row);
    while (!todo.empty()) {
      const auto [frame, at] = todo.top();
      todo.pop();
      if (is_blocked(obligations_[at].cube, frame)) {
        if (frame < top_frame()) todo.emplace(frame + 1, at);
        continue;
      }
      Cube core;
      const Answer answer = ask_into(obligations_[at].cube, frame, &core);
      if (answer == Answer::Unknown) {
        is_stopped_ = true;
        return std::nullopt;
      }
      if (answer == Answer::Satisfiable) {
        const u32 step = chosen_step();
        Obligation before{predecessor(obligations_[at].cube, step), frame - 1, at, step};
        drop_questions();
        const bool is_first = frame == 1 || meets_initial(before.cube, m_);
        obligations_.push_back(std::move(before));
        const u32 added = static_cast<u32>(obligations_.size()) - 1;
        if (is_first) return added;
        todo.emplace(frame - 1, added);
        todo.emplace(frame, at);
        continue;
      }
      u32 level = frame;
      if (!generalise(core, frame)) {
        is_stopped_ = true;
        return std::nullopt;
      }
      while (level < top_frame()) {
        const Answer further = ask_into(core, level + 1, nullptr);
        drop_questions();
        if (further != Answer::Unsatisfiable) break;
        ++level;
      }
      add_lemma(core, level);
      if (level < top_frame()) todo.emplace(level + 1, at);
    }
    return std::nullopt;
  }

  // Lemmas move up as far as they hold. False: stopped. Two equal frames: done.
  bool push() {
    for (u32 frame = 1; frame < top_frame(); ++frame) {
      const std::vector<Cube> lemmas = frames_[frame];
      for (const Cube& cube : lemmas) {
        Cube core;
        const Answer answer = ask_into(cube, frame + 1, &core);
        drop_questions();
        if (answer == Answer::Unknown) return false;
        if (answer == Answer::Unsatisfiable) {
          std::erase(frames_[frame], cube);
          add_lemma(core, frame + 1);
        }
      }
      if (frames_[frame].empty()) {
        answer_.end = Ic3End::Safe;
        answer_.frames = top_frame();
        for (u32 k = frame + 1; k < frames_.size(); ++k)
          answer_.lemmas.insert(answer_.lemmas.end(), frames_[k].begin(), frames_[k].end());
        return true;
      }
    }
    return true;
  }

  Ic3Answer reached(u32 row) {
    answer_.end = Ic3End::Reached;
    answer_.frames = top_frame();
    for (; obligations_[row].next != kNoRow; row = obligations_[row].next)
      answer_.steps.push_back(obligations_[row].step);
    answer_.bad_step = obligations_[row].step;
    return std::move(answer_);
  }

  const Ic3Problem& p_;
  const TransitionSystem& m_;
  Solver main_{SolverStyle::Plain}, lift_{SolverStyle::Plain};
  Cnf cnf_, lift_cnf_;
  Ic3Answer answer_;
  std::vector<u32> bits_, steps_;                       // relevant rows
  std::vector<Lit> now_, next_, lift_now_, lift_next_;  // by bit
  Lit bad_ = 0, lift_bad_ = 0, going_ = 0;
  std::vector<Signal> free_;               // inputs that are no bits
  std::vector<std::vector<Cube>> frames_;  // lemmas by the last frame in which they hold
  std::vector<Lit> switches_, to_drop_;
  std::vector<Obligation> obligations_;
  std::uint64_t questions_ = 0;
  bool is_stopped_ = false;
};

}  // namespace

Ic3Answer run_ic3(const Ic3Problem& problem) { return Pdr(problem).run(); }

bool meets_initial(const Cube& cube, const TransitionSystem& machine) {
  return std::none_of(cube.begin(), cube.end(), [&](u32 code) {
    const std::int8_t initial = machine.bits[code / 2].initial;
    return initial >= 0 && initial != static_cast<std::int8_t>(code & 1);
  });
}

}  // namespace bip::verify
