// What `bipc genom` puts around codels in C++: an exception ends its own activity, and nothing else. Header only.
//
// The text of an exception is kept until the reply with it (compiler/serve asks for it), so at most one a
// service.
#pragma once
#include <cstdio>
#include <exception>
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

template <class Codel>
int guarded(const char* name, const CodelOwner& owner, ReplyNotes& notes, const char* whose, int failed, Codel codel) {
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
