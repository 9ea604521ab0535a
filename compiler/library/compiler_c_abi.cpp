// The C interface over bip/compiler.hpp. See bip/compiler.h.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compiler/library/include/bip/compiler.h"
#include "compiler/library/include/bip/compiler.hpp"
#include "runtime/engine/copy_text.hpp"

struct bip_model {
  std::unique_ptr<bip::compiler::Model> model;
  const bip_image* image = nullptr;
  std::vector<bip::compiler::Diagnostic> diagnostics;
  std::string text;      // the diagnostics as bipc prints them
  std::string answered;  // by the last bip_verify
};

namespace bip::compiler {

namespace {

std::string text_of(const char* text) { return text == nullptr ? "" : text; }

bip_model* model_of(CompileResult compiled) {
  auto model = std::make_unique<bip_model>();
  model->model = std::move(compiled.model);
  model->diagnostics = std::move(compiled.diagnostics);
  model->text = std::move(compiled.text);
  if (model->model != nullptr) {
    for (Diagnostic& problem : model->model->prepare()) {
      model->text += problem.message + "\n";
      model->diagnostics.push_back(std::move(problem));
    }
    model->image = reinterpret_cast<const bip_image*>(model->model->image());
  }
  return model.release();
}

}  // namespace

}  // namespace bip::compiler

extern "C" {

bip_model* bip_compile_file(const char* path, const char* root) {
  return bip::compiler::model_of(
      bip::compiler::compile_file(bip::compiler::text_of(path), {.root = bip::compiler::text_of(root), .folders = {}}));
}
bip_model* bip_compile_text(const char* text, const char* root, const char* path) {
  return bip::compiler::model_of(bip::compiler::compile_text(bip::compiler::text_of(text),
                                                             {.root = bip::compiler::text_of(root), .folders = {}},
                                                             path == nullptr ? "model.bip" : path));
}
void bip_free_model(bip_model* model) { const std::unique_ptr<bip_model> owner(model); }

const bip_image* bip_model_image(const bip_model* model) { return model->image; }
size_t bip_diagnostic_count(const bip_model* model) { return model->diagnostics.size(); }
int bip_diagnostic_at(const bip_model* model, size_t k, bip_diagnostic* out) {
  if (k >= model->diagnostics.size()) return 0;
  const bip::compiler::Diagnostic& d = model->diagnostics[k];
  *out = {d.code.c_str(),
          d.severity == bip::compiler::Severity::Error ? 1 : 0,
          d.message.c_str(),
          d.file.c_str(),
          d.line,
          d.column,
          d.end_line,
          d.end_column};
  return 1;
}
size_t bip_diagnostics(const bip_model* model, char* buffer, size_t size) {
  return bip::rt::copy_text(model->text, buffer, size);
}

int bip_verify(bip_model* model, const char* property, double seconds) {
  model->answered.clear();
  if (model->model == nullptr) return BIP_NOT_ANSWERED;
  bip::compiler::VerifyOptions options;
  options.property = bip::compiler::text_of(property);
  options.timeout = seconds;
  const bip::compiler::Verdict verdict = model->model->verify(options);
  model->answered = verdict.is_answered ? verdict.text : verdict.problem;
  if (!verdict.is_answered) return BIP_NOT_ANSWERED;
  switch (verdict.outcome) {
    case bip::compiler::Outcome::Holds: return BIP_HOLDS;
    case bip::compiler::Outcome::Violated: return BIP_VIOLATED;
    case bip::compiler::Outcome::Unknown: break;
  }
  return BIP_UNKNOWN;
}
size_t bip_verify_text(const bip_model* model, char* buffer, size_t size) {
  return bip::rt::copy_text(model->answered, buffer, size);
}

}  // extern "C"
