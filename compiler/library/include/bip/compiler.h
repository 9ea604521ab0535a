/* C interface of bip/compiler.hpp: texts of models become images for bip/bip.h. In libbip_compiler.

   Texts are copied out as bip/bip.h says. No function throws or aborts on a user's input. Different models are
   independent; one model must not be used by two threads at the same time. */
#ifndef BIP_COMPILER_H
#define BIP_COMPILER_H
#include "bip/bip.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What came of compiling a text: a model, or what is wrong with it. */
typedef struct bip_model bip_model;

/* Compiles a file, .bip or .bsys, and makes code for its execution. `root`: "Ring(10)"; null or empty: the
   parameterless compound that no other one instantiates. Never null; bip_model_image says whether there is a model. The
   caller owns the result: bip_free_model. */
bip_model* bip_compile_file(const char* path, const char* root);
/* Compiles a text. `path`, which may be null, is what diagnostics call it; packages are looked for in its folder. */
bip_model* bip_compile_text(const char* text, const char* root, const char* path);
/* Destroys a model; null is allowed. Its executions must be destroyed before. */
void bip_free_model(bip_model* model);

/* Returns the image for bip_create, valid as long as the model; null if there are errors. */
const bip_image* bip_model_image(const bip_model* model);
/* Returns the number of errors and warnings. */
size_t bip_diagnostic_count(const bip_model* model);
/* An error or a warning. Its texts are valid as long as the model. */
typedef struct bip_diagnostic {
  const char* code; /* "B1003" */
  int is_error;     /* 0: a warning */
  const char* message;
  const char* file;
  uint32_t line, column, end_line, end_column; /* counted from 1, columns in bytes; line 0: there is no place */
} bip_diagnostic;
/* Sets *out to row k and returns 1, or returns 0 if there is no row k. */
int bip_diagnostic_at(const bip_model* model, size_t k, bip_diagnostic* out);
/* Copies all of them as `bipc` prints them. */
size_t bip_diagnostics(const bip_model* model, char* buffer, size_t size);

/* The answer to a property; bip_verify_text explains it. */
enum bip_verdict { BIP_HOLDS = 0, BIP_VIOLATED = 1, BIP_UNKNOWN = 2, BIP_NOT_ANSWERED = 3 };
/* Decides a property within `seconds` of the processor and returns a bip_verdict; null or empty: deadlock-freedom.
   BIP_NOT_ANSWERED: there is no model, or the text is no property. Linear to exponential in the model. */
int bip_verify(bip_model* model, const char* property, double seconds);
/* Copies what the last bip_verify found, as `bipc verify` prints it: the verdict, and the counterexample if there is
   one. */
size_t bip_verify_text(const bip_model* model, char* buffer, size_t size);

#ifdef __cplusplus
}
#endif
#endif
