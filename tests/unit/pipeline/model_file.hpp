// A model in a file, for tests of what reads files.
#pragma once
#include <fstream>
#include <string>
#include <utility>

#include "compiler/pipeline/host_compiler.hpp"

namespace bip::pipeline {

/// A model in a directory that disappears with the test.
class ModelFile {
 public:
  explicit ModelFile(const std::string& text) : directory_(std::move(*TemporaryDirectory::make())) {
    std::ofstream(path(), std::ios::binary) << text;
  }
  [[nodiscard]] std::string path() const { return directory_.path() + "/m.bip"; }

 private:
  TemporaryDirectory directory_;
};

}  // namespace bip::pipeline
