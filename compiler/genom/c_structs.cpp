// See c_structs.hpp.
#include "compiler/genom/c_structs.hpp"

#include <map>
#include <string_view>

namespace bip::genom {
namespace {

class StructReader {
 public:
  explicit StructReader(const std::vector<Token>& tokens) : tokens_(tokens) {}

  std::vector<CStruct> run() {
    while (at_ < tokens_.size()) {
      const bool is_typedef = is("typedef");
      if (is_typedef) ++at_;
      if (is("struct")) read_struct(is_typedef);
      else if (is_typedef) read_typedef();
      else ++at_;
    }
    return std::move(structs_);
  }

 private:
  [[nodiscard]] bool is(std::string_view text) const { return at_ < tokens_.size() && tokens_[at_].is(text); }
  [[nodiscard]] bool is_word() const { return at_ < tokens_.size() && tokens_[at_].kind == TokenKind::Word; }
  std::string take() { return std::string(tokens_[at_++].text); }

  // struct [TAG] { members } [NAME] ;   Anything else is passed over.
  void read_struct(bool is_typedef) {
    ++at_;
    CStruct row;
    if (is_word()) row.tag = take();
    if (!is("{")) return;
    ++at_;
    bool is_sound = true;
    while (at_ < tokens_.size() && !is("}")) is_sound = read_members(row.members) && is_sound;
    if (at_ < tokens_.size()) ++at_;
    if (is_typedef && is_word()) row.name = take();
    if (row.name.empty()) row.name = row.tag;
    if (is_sound && !row.name.empty()) structs_.push_back(std::move(row));
  }

  // type name [n] {, name [n]} ;
  bool read_members(std::vector<CMember>& members) {
    std::vector<std::string> words;
    while (is_word()) words.push_back(take());
    bool is_sound = words.size() >= 2;
    std::string name = words.empty() ? "" : words.back();
    if (!words.empty()) words.pop_back();
    const std::string type = plain(words);
    while (is_sound) {
      CMember member{type, name, {}};
      while (is("[")) {
        ++at_;
        std::int64_t length = -1;
        if (at_ + 1 < tokens_.size() && tokens_[at_].kind == TokenKind::Number && tokens_[at_ + 1].is("]")) {
          if (!whole_number(tokens_[at_].text, length)) length = -1;
        }
        while (at_ < tokens_.size() && !is("]") && !is(";")) ++at_;
        if (is("]")) ++at_;
        member.dimensions.push_back(length);
      }
      members.push_back(std::move(member));
      if (!is(",")) break;
      ++at_;
      is_sound = is_word();
      if (is_sound) name = take();
    }
    is_sound = is_sound && is(";");
    // A member that is not understood ends at its `;`, over braces.
    int depth = 0;
    for (; at_ < tokens_.size() && !(depth == 0 && (is(";") || is("}"))); ++at_)
      depth += is("{") ? 1 : is("}") ? -1 : 0;
    if (is(";")) ++at_;
    return is_sound;
  }

  // typedef words NAME ;   typedef enum [TAG] { … } NAME ;
  void read_typedef() {
    std::vector<std::string> words;
    const bool is_enum = is("enum");
    while (is_word()) words.push_back(take());
    if (is_enum && is("{")) {
      while (at_ < tokens_.size() && !is("}")) ++at_;
      if (at_ < tokens_.size()) ++at_;
      if (is_word()) aliases_[take()] = "int";
      return;
    }
    if (words.size() < 2 || !is(";")) return;
    const std::string name = words.back();
    words.pop_back();
    aliases_[name] = is_enum ? "int" : plain(words);
  }

  // "unsigned long int" is "unsigned long"; a name of `typedef` is what it stands for.
  [[nodiscard]] std::string plain(std::vector<std::string> words) const {
    std::erase(words, "const");
    std::erase(words, "volatile");
    if (words.size() > 1) std::erase(words, "signed");
    if (words.size() > 1) std::erase(words, "int");
    std::string type;
    for (const std::string& word : words) type += (type.empty() ? "" : " ") + word;
    if (type.starts_with("enum ")) return "int";
    const auto alias = aliases_.find(type);
    return alias == aliases_.end() ? type : alias->second;
  }

  const std::vector<Token>& tokens_;
  std::size_t at_ = 0;
  std::map<std::string, std::string> aliases_;
  std::vector<CStruct> structs_;
};

}  // namespace

std::vector<CStruct> read_c_structs(const std::vector<Token>& tokens) { return StructReader(tokens).run(); }

std::vector<DataRef> read_data_refs(const std::vector<std::string>& words) {
  std::vector<DataRef> refs;
  for (std::size_t k = 0; k < words.size(); ++k) {
    DataRef ref{words[k], {}};
    if (k + 2 >= words.size() || words[k + 1] != "::") return {};
    k += 2;
    if (words[k] != "all") ref.path.push_back(words[k]);
    for (; k + 2 < words.size() && words[k + 1] == "."; k += 2) ref.path.push_back(words[k + 2]);
    refs.push_back(std::move(ref));
    if (++k < words.size() && words[k] != ",") return {};
  }
  return refs;
}

}  // namespace bip::genom
