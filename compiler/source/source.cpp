// The source map: reads and checks files once, then answers questions about lines.
//
// Needs readable files of at most kMaxFileBytes that are UTF-8 without NUL bytes. Line breaks are \n or \r\n; a lone \r
// is a blank. Promises that texts never move. Reading is linear, `loc` is a binary search over line starts.
#include "compiler/source/source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {
namespace {

std::vector<std::uint32_t> line_starts_of(std::string_view text) {
  std::vector<std::uint32_t> starts{0};
  for (std::size_t at = text.find('\n'); at != std::string_view::npos; at = text.find('\n', at + 1)) {
    starts.push_back(static_cast<std::uint32_t>(at + 1));
  }
  return starts;
}

std::string line_and_column(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t last = before.rfind('\n');
  const std::size_t column = last == std::string_view::npos ? offset + 1 : offset - last;
  return std::to_string(line) + ":" + std::to_string(column);
}

Failure system_failure(int error) { return {std::strerror(error)}; }

Failure too_large() { return {"larger than the limit of " + std::to_string(SourceMap::kMaxFileBytes >> 20) + " MiB"}; }

// Reads to the end whatever the size said: pipes and /dev/stdin have none.
Result<std::string> read_all(int fd) {
  std::string text;
  std::string chunk(1u << 16, '\0');
  for (;;) {
    const ssize_t got = ::read(fd, chunk.data(), chunk.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_failure(errno);
    if (got == 0) return text;
    text.append(chunk, 0, static_cast<std::size_t>(got));
    if (text.size() > SourceMap::kMaxFileBytes) {
      return too_large();
    }
  }
}

Result<std::string> read_file(const std::string& path) {
  if (path == "-") return read_all(STDIN_FILENO);
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return errno == ENOENT ? Failure{"no such file"} : system_failure(errno);
  struct stat status {};
  if (::fstat(fd, &status) == 0 && S_ISDIR(status.st_mode)) {
    ::close(fd);
    return Failure{"is a directory"};
  }
  Result<std::string> text = read_all(fd);
  ::close(fd);
  return text;
}

}  // namespace

FileId SourceMap::add(std::string name, std::string text) {
  BIP_ENSURE(text.size() <= kMaxFileBytes);
  File file;
  file.name = std::move(name);
  file.text = std::move(text);
  file.line_starts = line_starts_of(file.text);
  BIP_ASSERT(std::is_sorted(file.line_starts.begin(), file.line_starts.end()), "lines of {} are in order", file.name);
  files_.push_back(std::move(file));
  return FileId(files_.size() - 1);
}

Result<FileId> SourceMap::load(const std::string& path, std::string name) {
  Result<std::string> text = read_file(path);
  if (!text) return Failure{text.error()};
  if (name.empty()) name = path == "-" ? "standard input" : path;
  return load_text(std::move(name), std::move(*text));
}

Result<FileId> SourceMap::load_text(std::string name, std::string text) {
  if (text.size() > kMaxFileBytes) return too_large();
  if (const auto bad = first_bad_utf8(text)) {
    static constexpr char kHex[] = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(text[*bad]);
    const std::string shown{'0', 'x', kHex[byte >> 4], kHex[byte & 15u]};
    return Failure{"not UTF-8: byte " + shown + " at " + line_and_column(text, *bad)};
  }
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos) {
    return Failure{"not a text: NUL byte at " + line_and_column(text, nul)};
  }
  return add(std::move(name), std::move(text));
}

std::string_view SourceMap::text(FileId id) const {
  BIP_ASSERT(id.value < files_.size(), "file {} of {}", id, files_.size());
  return files_[id.value].text;
}

std::string_view SourceMap::text(SourceRange r) const {
  const std::string_view whole = text(r.file);
  BIP_ASSERT(r.begin <= r.end, "a range from {} to {}", r.begin, r.end);
  const std::size_t begin = std::min<std::size_t>(r.begin, whole.size());
  return whole.substr(begin, r.end > r.begin ? r.end - r.begin : 0);
}

const std::string& SourceMap::name(FileId id) const {
  BIP_ASSERT(id.value < files_.size(), "file {} of {}", id, files_.size());
  return files_[id.value].name;
}

Loc SourceMap::loc(FileId id, std::uint32_t offset) const {
  BIP_ASSERT(id.value < files_.size(), "file {} of {}", id, files_.size());
  BIP_ASSERT(offset <= files_[id.value].text.size(), "offset {} of {} bytes", offset, files_[id.value].text.size());
  const std::vector<std::uint32_t>& starts = files_[id.value].line_starts;
  const auto after = std::upper_bound(starts.begin(), starts.end(), offset);
  const auto line = static_cast<std::uint32_t>(after - starts.begin());
  BIP_ASSERT(line >= 1 && line <= starts.size(), "line {} of {}", line, starts.size());
  return {.file = id.value, .line = line, .column = offset - starts[line - 1] + 1};
}

std::string_view SourceMap::line(FileId id, std::uint32_t line) const {
  const File& file = files_[id.value];
  if (line == 0 || line > file.line_starts.size()) return {};
  const std::size_t begin = file.line_starts[line - 1];
  std::size_t end = line < file.line_starts.size() ? file.line_starts[line] - 1 : file.text.size();
  if (end > begin && file.text[end - 1] == '\r') --end;
  return std::string_view(file.text).substr(begin, end - begin);
}

}  // namespace bip
