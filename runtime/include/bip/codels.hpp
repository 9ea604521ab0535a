// What `bipc genom` puts around codels in C++: an exception ends its own activity, and nothing else. Header only.
//
// The text of an exception is kept until the reply with it (compiler/serve asks for it), so at most one a
// service.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

namespace bip {

/// Whose codel is called: an activity "NDD.GoTo_2" of the service "NDD.GoTo", or a task, which has no replies.
struct CodelOwner {
  const char* name = "";
  const char* service = "";
};
/// What BIP hears of a codel that threw.
inline constexpr int kCodelThrew = 203, kCodelRefuses = -1;

/// A text as JSON has it, with its quotes. Bytes above 127 stay.
inline std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    char escape[8];
    if (c == '"' || c == '\\') out.append(1, '\\').append(1, c);
    else if (static_cast<unsigned char>(c) >= 0x20) out += c;
    else if (std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(c)) > 0) out += escape;
  }
  return out + "\"";
}

/// Members of a JSON object for the next reply of an activity, or of a service that did not become one. Any thread.
class ReplyNotes {
 public:
  void note(const std::string& whose, std::string members) {
    const std::lock_guard<std::mutex> hold(lock_);
    members_[whose] = std::move(members);
  }
  /// Empty: there are none.
  [[nodiscard]] std::string take(const std::string& whose) {
    const std::lock_guard<std::mutex> hold(lock_);
    const auto found = members_.find(whose);
    if (found == members_.end()) return {};
    std::string members = std::move(found->second);
    members_.erase(found);
    return members;
  }

 private:
  std::mutex lock_;
  std::map<std::string, std::string> members_;
};
inline ReplyNotes& activity_notes() {
  static ReplyNotes notes;
  return notes;
}
inline ReplyNotes& service_notes() {
  static ReplyNotes notes;
  return notes;
}

inline void note_exception(const char* codel, const CodelOwner& owner, ReplyNotes& notes, const char* whose,
                           const char* what) {
  std::fprintf(stderr, "warning[R0048]: codel `%s` of %s threw an exception%s%s\n", codel, owner.name,
               *what == '\0' ? "" : ": ", what);
  if (*whose == '\0') return;
  notes.note(whose, "\"exception\":{\"codel\":" + json_text(codel) + ",\"what\":" + json_text(what) + "}");
}

/// What asks for a service as clients do, with an input of JSON, and waits for its final reply:
/// {"report":"OK","result":{…}}, or {"report":"","problem":"there is no service …"}. The text lasts until the thread
/// asks again. `bipc serve` sets it; null: there are no services.
using ServiceCaller = const char* (*)(const char* service, const char* input);
inline std::atomic<ServiceCaller>& service_caller() {
  static std::atomic<ServiceCaller> caller{nullptr};
  return caller;
}

/// How long the codels of a program took, by name. Any thread.
class CodelTimes {
 public:
  /// Of one codel.
  struct Row {
    std::uint64_t calls = 0, over = 0;
    std::chrono::nanoseconds total{0}, longest{0}, budget{0};
    const char* text = nullptr;  // its name, where it was looked up last
  };
  /// What a call of it may take.
  void set_budget(const char* codel, std::chrono::microseconds budget) {
    const std::lock_guard<std::mutex> hold(lock_);
    find(codel).budget = budget;
  }
  /// Returns whether it took longer than it may. last: the row of the caller's last call, which mostly is of the same
  /// codel; null at first. Only this function changes it.
  bool add(const char* codel, std::chrono::nanoseconds took, Row*& last) {
    const std::lock_guard<std::mutex> hold(lock_);
    if (last == nullptr || last->text != codel) {
      last = &find(codel);
      last->text = codel;
    }
    Row& row = *last;
    ++row.calls;
    row.total += took;
    row.longest = std::max(row.longest, took);
    const bool is_over = row.budget.count() > 0 && took > row.budget;
    if (is_over) ++row.over;
    return is_over;
  }
  /// An array of objects, by name; those that were called.
  [[nodiscard]] std::string json() const {
    const std::lock_guard<std::mutex> hold(lock_);
    std::string out;
    for (const auto& [name, row] : rows_) {
      if (row.calls == 0) continue;
      out += (out.empty() ? "[" : ",") + std::string("{\"codel\":") + json_text(name) +
             ",\"calls\":" + std::to_string(row.calls) + ",\"ns\":" + std::to_string(row.total.count()) +
             ",\"longest_ns\":" + std::to_string(row.longest.count());
      if (row.budget.count() > 0)
        out += ",\"wcet_ns\":" + std::to_string(row.budget.count()) + ",\"over_wcet\":" + std::to_string(row.over);
      out += "}";
    }
    return (out.empty() ? "[" : out) + "]";
  }

 private:
  Row& find(const char* codel) {
    const auto found = rows_.find(std::string_view(codel));
    return found != rows_.end() ? found->second : rows_[codel];
  }

  mutable std::mutex lock_;
  std::map<std::string, Row, std::less<>> rows_;
};
inline CodelTimes& codel_times() {
  static CodelTimes times;
  return times;
}
/// Did the last codel that this thread called take longer than it may?
inline bool& codel_was_late() {
  thread_local bool was_late = false;
  return was_late;
}
/// Of one call: from here to the end of the block.
class CodelTimer {
 public:
  explicit CodelTimer(const char* codel) : codel_(codel) {}
  /// last: see CodelTimes::add; outlives the timer.
  CodelTimer(const char* codel, CodelTimes::Row*& last) : codel_(codel), last_(&last) {}
  CodelTimer(const CodelTimer&) = delete;
  CodelTimer& operator=(const CodelTimer&) = delete;
  ~CodelTimer() {
    CodelTimes::Row* none = nullptr;
    const auto took = std::chrono::steady_clock::now() - begun_;
    codel_was_late() = codel_times().add(codel_, took, last_ != nullptr ? *last_ : none);
  }

 private:
  const char* codel_;
  CodelTimes::Row** last_ = nullptr;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};
struct CodelBudget {
  const char* codel = "";
  std::int64_t us = 0;
};
template <std::size_t n>
bool set_codel_budgets(const CodelBudget (&budgets)[n]) {
  for (const CodelBudget& b : budgets) codel_times().set_budget(b.codel, std::chrono::microseconds(b.us));
  return true;
}
/// For `bipc serve` and `bipc run --profile`. The text lasts until the thread asks again.
inline const char* codel_times_text() {
  thread_local std::string text;
  text = codel_times().json();
  return text.c_str();
}

template <class Codel>
int guarded(const char* name, const CodelOwner& owner, ReplyNotes& notes, const char* whose, int failed, Codel codel) {
  // A codel's call has a type of its own, in most programs.
  static CodelTimes::Row* last = nullptr;
  const CodelTimer timer(name, last);
  try {
    return codel();
  } catch (const std::exception& exception) {
    note_exception(name, owner, notes, whose, exception.what());
  } catch (...) {
    note_exception(name, owner, notes, whose, "");
  }
  return failed;
}
/// What a codel of an activity or of a task answers, or kCodelThrew.
template <class Codel>
int guarded_step(const char* name, const CodelOwner& owner, Codel codel) {
  return guarded(name, owner, activity_notes(), owner.name, kCodelThrew, codel);
}
/// What a codel answers that judges or does a request at once, or kCodelRefuses.
template <class Codel>
int guarded_control(const char* name, const CodelOwner& owner, Codel codel) {
  return guarded(name, owner, service_notes(), owner.service, kCodelRefuses, codel);
}

/// For `bipc serve`: a JSON object for the final reply of an activity, else of a service; empty if there is nothing to
/// tell. The text lasts until the thread asks again.
inline const char* reply_result(const char* whose, bool is_activity) {
  thread_local std::string text;
  text = (is_activity ? activity_notes() : service_notes()).take(whose);
  if (!text.empty()) text = "{" + text + "}";
  return text.c_str();
}

}  // namespace bip
