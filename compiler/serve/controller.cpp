// See controller.hpp.
#include "compiler/serve/controller.hpp"

#include "bip/assert.hpp"
#include "bip/real_time_thread.hpp"

namespace bip::serve {

Controller::Controller(const rt::Image& image, const ExecutionOptions& options, Begin begin)
    : image_(image), system_(image, options), is_paused_(begin == Begin::Paused) {}

Controller::~Controller() { halt(); }

void Controller::halt() {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    quits_ = true;
    system_.stop();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Controller::start() {
  BIP_ASSERT(!thread_.joinable(), "the controller runs already");
  system_.on_step([this](const Step& step) {
    if (on_step) on_step(step, system_.now());
  });
  thread_ = std::thread([this] { run(); });
}

void Controller::ask(Command command) {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    commands_.push_back(std::move(command));
    system_.stop();
  }
  changed_.notify_all();
}

void Controller::resume(std::uint64_t steps) {
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
  has_ended_ = false;
  return true;
}

void Controller::end(Outcome outcome) {
  has_ended_ = true;
  if (on_end) on_end(outcome, outcome == Outcome::Fault ? system_.fault() : system_.story());
}

void Controller::run() {
  rt::RealTimeThread thread(real_time_priority != 0);
  if (real_time_priority != 0) thread.raise(real_time_priority);
  if (!thread.problem().empty() && on_problem) on_problem(thread.problem());
  system_.restart_clock();
  std::deque<Command> commands;
  if (system_.outcome() == Outcome::Fault) end(Outcome::Fault);
  while (true) {
    {
      std::unique_lock<std::mutex> hold(lock_);
      changed_.wait(hold, [this] { return quits_ || !commands_.empty() || (!is_paused_ && !has_ended_); });
      if (quits_) return;
      commands.swap(commands_);
      system_.go_on();
    }
    for (Command& command : commands) command(*this);
    commands.clear();
    if (is_paused_ || has_ended_) continue;
    BIP_ASSERT(commands.empty(), "{} commands were not carried out", commands.size());
    const Outcome outcome = system_.step();
    if (outcome == Outcome::Stepped && steps_left_ != 0 && --steps_left_ == 0) is_paused_ = true;
    if (outcome == Outcome::Deadlock || outcome == Outcome::Final || outcome == Outcome::Fault) end(outcome);
  }
}

}  // namespace bip::serve
