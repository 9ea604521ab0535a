// Compiles emitted text into a shared object and gives its image, so that tests compare it with the interpreter's.
#pragma once
#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "compiler/emit_cpp/emit_cpp.hpp"

namespace bip::test {

inline std::filesystem::path repository() { return BIP_TEST_SOURCE_DIR; }

/// A directory that goes with the object.
class ScratchDir {
 public:
  ScratchDir() {
    std::string name = (std::filesystem::temp_directory_path() / "bip_emit_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~ScratchDir() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDir(const ScratchDir&) = delete;
  ScratchDir& operator=(const ScratchDir&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Emitted code, compiled with every warning an error. `level` is "-O0" or "-O2".
class Compiled {
 public:
  Compiled(const std::string& text, const std::string& level) {
    const std::filesystem::path source = dir_.path() / "model.cpp";
    const std::filesystem::path object = dir_.path() / "model.so";
    std::ofstream(source) << text;
    const char* compiler = std::getenv("CXX");
    const std::string command = std::string(compiler != nullptr ? compiler : "c++") + " -std=c++20 " + level +
                                " -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -Wno-xor-used-as-pow "
                                "-ffp-contract=off -shared -fPIC -I" +
                                (repository() / "runtime/include").string() + " -o " + object.string() + " " +
                                source.string();
    if (std::system(command.c_str()) != 0) return;
    handle_ = dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
  }
  ~Compiled() {
    if (handle_ != nullptr) dlclose(handle_);
  }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;

  /// `model::image()`; null if the text did not compile.
  [[nodiscard]] const rt::Image* image() const {
    if (handle_ == nullptr) return nullptr;
    void* symbol = dlsym(handle_, "_ZN5model5imageEv");
    if (symbol == nullptr) return nullptr;
    return &reinterpret_cast<const rt::Image& (*)()>(symbol)();
  }

 private:
  ScratchDir dir_;
  void* handle_ = nullptr;
};

}  // namespace bip::test
