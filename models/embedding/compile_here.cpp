// Compiles a model in this process, runs it by the JIT or the interpreter, and looks for its deadlock.
#include <cstdio>

#include "bip/compiler.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const bip::compiler::CompileResult compiled = bip::compiler::compile_file(argv[1], {.root = "Table(4)"});
  if (!compiled.model) {
    std::fputs(compiled.text.c_str(), stderr);
    return 1;
  }
  bip::Execution system = compiled.model->start({.seed = 3});
  const unsigned long long steps = system.run(1000);
  std::printf("%llu steps, %s\n", steps, system.outcome() == bip::Outcome::Deadlock ? "then a deadlock" : "and more");
  const bip::compiler::Verdict verdict = compiled.model->verify();
  std::printf("%s", verdict.text.c_str());
  return verdict.counterexample && verdict.counterexample->steps.size() == 4 ? 0 : 1;
}
