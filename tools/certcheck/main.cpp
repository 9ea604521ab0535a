// certcheck SYSTEM.bsys CERTIFICATE: exit code 0 accepted, 1 rejected, 2 usage, 4 not checkable.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tools/certcheck/check.hpp"

namespace {

std::string read_file(const char* path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw certcheck::Rejected(std::string("cannot read `") + path + "`");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: certcheck SYSTEM.bsys CERTIFICATE\n", stderr);
    return 2;
  }
  try {
    certcheck::Model model;
    certcheck::read_model(read_file(argv[1]), model);
    const std::string told = certcheck::check(model, read_file(argv[2]));
    std::printf("accepted: %s\n", told.c_str());
    // What is left need not be taken apart.
    std::fflush(stdout);
    std::_Exit(0);
  } catch (const certcheck::NotCheckable& e) {
    std::printf("not checkable: %s\n", e.what());
    return 4;
  } catch (const std::exception& e) {
    std::printf("rejected: %s\n", e.what());
    return 1;
  }
}
