// The command line of a program that serves a model: see bip/serve.hpp.
#include "bip/serve.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdio>

#include "bip/process.hpp"
#include "compiler/serve/serve_image.hpp"
#include "runtime/core/text.hpp"

namespace bip::serve {

namespace {

std::string head_of(const ServeOption& option) {
  return option.name + (option.value.empty() ? "" : " " + option.value);
}

void print_help(const char* program, const rt::Image& image) {
  std::printf(
      "usage: %s [options]\nserves the model %s in real time while clients post events, observe it and control "
      "it\n\n",
      program, image.name);
  for (const ServeOption& option : serve_options()) {
    if (!option.help.empty()) std::printf("  %s\n        %s\n", head_of(option).c_str(), option.help.c_str());
  }
  std::printf(
      "  --help\n        print this help\n  --version\n        print the name of the model\n\n"
      "Requests and answers are lines of JSON, as of `bipc serve`.\nexample: echo '{\"do\":\"hello\"}' | %s\n",
      program);
}

int fail(const char* program, const std::string& problem) {
  std::fprintf(stderr, "%s: %s, see --help\n", rt::printable(program).c_str(), rt::printable(problem).c_str());
  return kUsage;
}

// What run_process() hands on is a function without context.
const rt::Image* image_of_program = nullptr;

int serve_arguments(int argc, char** argv) {
  const rt::Image& image = *image_of_program;
  const char* const program = argc > 0 ? argv[0] : "model";
  ServeSettings settings;
  for (int i = 1; i < argc; ++i) {
    // --name value and --name=value alike.
    std::string name = argv[i], value;
    const std::size_t equals = name.find('=');
    const bool is_joined = name.starts_with("--") && equals != std::string::npos;
    if (is_joined) {
      value = name.substr(equals + 1);
      name.resize(equals);
    }
    if (name == "--help" || name == "-h") {
      print_help(program, image);
      return 0;
    }
    if (name == "--version") {
      std::printf("model %s, served, compiled by bipc\n", image.name);
      return 0;
    }
    const auto& options = serve_options();
    const auto option =
        std::find_if(options.begin(), options.end(), [&](const ServeOption& row) { return row.name == name; });
    if (option == options.end()) return fail(program, "no option `" + name + "` here");
    if (option->value.empty() && is_joined) return fail(program, "`" + name + "` takes no value");
    if (!option->value.empty() && !is_joined) {
      if (i + 1 == argc) return fail(program, "`" + name + "` needs a value");
      value = argv[++i];
    }
    if (const std::string wrong = option->read(value, settings); !wrong.empty())
      return fail(program, name + ": " + wrong);
  }
  return serve_image(image, image.ffi == nullptr ? nullptr : ::dlopen(nullptr, RTLD_NOW), settings);
}

}  // namespace

}  // namespace bip::serve

namespace bip {

int serve_main(const rt::Image& image, int argc, char** argv) {
  serve::image_of_program = &image;
  return run_process(serve::serve_arguments, argc, argv);
}

}  // namespace bip
