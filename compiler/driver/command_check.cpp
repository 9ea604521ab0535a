// `bipc check`: reports everything that can be wrong without running. Prints nothing if there is nothing to report.
// With `--lesson` it judges an exercise of the book.
#include <algorithm>
#include <cstdio>

#include "bip/process.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/judge_lesson.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

namespace {

int check_files(const CheckArguments& arguments) {
  int worst = 0;
  for (const std::string& file : arguments.files) {
    Compilation c(arguments.compile);
    if (arguments.compile.emit != EmitKind::None) {
      emit_stage(c, file, Optimisation::Auto);
    } else if (!arguments.placement_path.empty()) {
      std::string text;
      const bool is_compiled = compile(c, file, Stage::Image);
      if (arguments.json) text = distribution_json(c, file, arguments.placement_path);
      else if (is_compiled) text = distribution_text(c, arguments.placement_path);
      std::fwrite(text.data(), 1, text.size(), stdout);
    } else {
      (void)check(c, file);
    }
    worst = std::max(worst, report(c));
  }
  return worst;
}

}  // namespace

int command_check(const CheckArguments& arguments) {
  const int code = arguments.lesson.empty() ? check_files(arguments) : judge_lesson(arguments);
  // What other commands say beside their product is the product here.
  return std::ferror(stderr) != 0 ? kOutputLost : code;
}

}  // namespace bip::driver
