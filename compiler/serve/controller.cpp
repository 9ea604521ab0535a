// See controller.hpp.
#include "compiler/serve/controller.hpp"

#include "bip/assert.hpp"
#include "bip/real_time_thread.hpp"

namespace bip::serve {

Controller::Controller(const rt::Image& image, const ExecutionOptions& options, Begin begin, const WatchOptions& watch)
    : image_(image),
      system_(image, options),
      requests_(image, system_),
      watchdog_(system_, watch),
      is_paused_(begin == Begin::Paused) {}

Controller::~Controller() { halt(); }

void Controller::halt() {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    quits_ = true;
    is_asked_.store(true);
    system_.stop();
  }
  requests_.end_calls();
  changed_.notify_all();
  if (thread_.joinable()) {
    thread_.join();
    watchdog_.stop_robot("the model is not served any more");
  }
  watchdog_.halt();
}

void Controller::start() {
  BIP_ASSERT(!thread_.joinable(), "the controller runs already");
  system_.on_step(
      [this](const Step& step) {
        if (on_step) on_step(step, system_.now());
        requests_.note_step(step);
        watchdog_.note_step(step);
      },
      [this](const std::string& port) { return requests_.hears(port); });
  name_all_steps(false);
  thread_ = std::thread([this] { run(); });
  watchdog_.start();
}

void Controller::ask(Command command) {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    commands_.push_back(std::move(command));
    is_asked_.store(true);
    system_.stop();
  }
  changed_.notify_all();
}

// Before a step that a client asked for. The oldest states go first. States that back() refuses to restore would keep
// their strings for nothing.
void Controller::note_state() {
  if (image_.ffi != nullptr) return;
  undo_.push_back(system_.snapshot());
  undo_bytes_ += undo_.back().bytes();
  while (undo_.size() > kMostUndone || (undo_bytes_ > kMostUndoneBytes && undo_.size() > 1)) {
    undo_bytes_ -= undo_.front().bytes();
    undo_.pop_front();
  }
  BIP_ASSERT(!undo_.empty() && undo_.size() <= kMostUndone, "{} states are kept", undo_.size());
}

// The state before a step that was not taken.
void Controller::drop_state() {
  if (image_.ffi != nullptr) return;
  BIP_ASSERT(!undo_.empty() && undo_bytes_ >= undo_.back().bytes(), "{} states have {} bytes", undo_.size(),
             undo_bytes_);
  undo_bytes_ -= undo_.back().bytes();
  undo_.pop_back();
}

void Controller::forget_states() {
  undo_.clear();
  undo_bytes_ = 0;
}

std::string Controller::fire(std::uint64_t k) {
  if (has_ended_) return "the run has ended";
  if (!is_paused_) return "the model is not paused";
  if (k >= system_.candidate_count())
    return "there is no candidate " + std::to_string(k) + ": there are " + std::to_string(system_.candidate_count());
  note_state();
  note_outcome(system_.fire(k));
  return {};
}

std::string Controller::back(std::uint64_t count) {
  if (!is_paused_ && !has_ended_) return "the model is not paused";
  if (image_.ffi != nullptr)
    return "the model calls C++, or events bring it texts or values of C++: what these hold cannot be restored";
  if (count > undo_.size()) return "only " + std::to_string(undo_.size()) + " steps can be undone";
  for (; count > 0; --count) {
    if (count == 1) system_.restore(undo_.back());
    drop_state();
  }
  requests_.forget();
  has_ended_ = false;
  is_paused_ = true;
  return {};
}

void Controller::pause() {
  if (!is_paused_ && !has_ended_) watchdog_.stop_robot("the model is paused");
  is_paused_ = true;
}

void Controller::resume(std::uint64_t steps) {
  if (steps == 0) forget_states();
  if (is_paused_) system_.restart_clock();
  is_paused_ = false;
  steps_left_ = steps;
}

bool Controller::save(std::size_t& number) {
  if (snapshots_.size() >= kMaxSnapshots) return false;
  number = snapshots_.size();
  snapshots_.push_back(system_.snapshot());
  return true;
}

bool Controller::restore(std::size_t number) {
  if (number >= snapshots_.size()) return false;
  system_.restore(snapshots_[number]);
  requests_.forget();
  forget_states();
  has_ended_ = false;
  return true;
}

void Controller::note_outcome(Outcome outcome) {
  if (outcome == Outcome::Deadlock || outcome == Outcome::Final || outcome == Outcome::Fault) end(outcome);
}

void Controller::end(Outcome outcome) {
  BIP_ASSERT(!has_ended_, "the run ends twice, now by {}", outcome);
  has_ended_ = true;
  watchdog_.stop_robot(outcome == Outcome::Fault      ? "the run has ended by an error"
                       : outcome == Outcome::Deadlock ? "the run has ended in a deadlock"
                                                      : "the run has ended");
  if (on_end) on_end(outcome, outcome == Outcome::Fault ? system_.fault() : system_.story());
}

void Controller::run() {
  rt::RealTimeThread thread(real_time_priority != 0);
  if (real_time_priority != 0) thread.raise(real_time_priority);
  if (!thread.problem().empty() && on_problem) on_problem(thread.problem());
  system_.restart_clock();
  watchdog_.enter_thread();
  std::deque<Command> commands;
  if (system_.outcome() == Outcome::Fault) end(Outcome::Fault);
  while (true) {
    // Nearly all steps find nothing that was asked for: they take no lock.
    if (is_asked_.load() || is_paused_ || has_ended_) {
      std::unique_lock<std::mutex> hold(lock_);
      changed_.wait(hold, [this] { return quits_ || !commands_.empty() || (!is_paused_ && !has_ended_); });
      if (quits_) break;
      commands.swap(commands_);
      is_asked_.store(false);
      system_.go_on();
    }
    if (!commands.empty()) {
      watchdog_.begin();
      for (Command& command : commands) command(*this);
      commands.clear();
      watchdog_.end();
    }
    if (is_paused_ || has_ended_) continue;
    BIP_ASSERT(commands.empty(), "{} commands were not carried out", commands.size());
    if (steps_left_ != 0) note_state();
    watchdog_.begin();
    const Outcome outcome = system_.step();
    watchdog_.end();
    if (outcome != Outcome::Stepped && steps_left_ != 0) drop_state();
    if (outcome == Outcome::Stepped && steps_left_ != 0 && --steps_left_ == 0) pause();
    note_outcome(outcome);
  }
  watchdog_.leave_thread();
}

}  // namespace bip::serve
