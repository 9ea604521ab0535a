// certcheck SYSTEM.bsys CERTIFICATE: exit code 0 accepted, 1 rejected, 2 usage, 4 not checkable, 71 memory, 74 output.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tools/certcheck/checked_model.hpp"

static std::ifstream open_file(const char* path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw certcheck::Rejected("cannot read " + certcheck::quoted(path));
  return in;
}

// One line of printable ASCII: words of an untrusted file must not drive the reader's terminal, which could show
// another verdict then.
static std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) out += c >= ' ' && c <= '~' ? std::string(1, c) : "\xEF\xBF\xBD";
  return out;
}

// A verdict that cannot be written is none.
static int finish(int code) {
  const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  return is_written ? code : (std::perror("certcheck: cannot write standard output"), 74);
}

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("usage: certcheck SYSTEM.bsys CERTIFICATE\n", stderr), 2;
  try {
    z3::context z;
    std::ifstream system = open_file(argv[1]), certificate = open_file(argv[2]);
    const std::string systems{std::istreambuf_iterator<char>(system), {}};
    std::printf("accepted: %s\n", plain(certcheck::check_all(systems, certificate, z)).c_str());
    // What is left need not be taken apart.
    std::_Exit(finish(0));
  } catch (const certcheck::NotCheckable& e) {
    return std::printf("not checkable: %s\n", plain(e.what()).c_str()), finish(4);
  } catch (const std::exception& e) {
    const bool is_memory = dynamic_cast<const std::bad_alloc*>(&e) != nullptr;
    return std::printf("%s: %s\n", is_memory ? "out of memory" : "rejected", plain(e.what()).c_str()),
           finish(is_memory ? 71 : 1);
  }
}
