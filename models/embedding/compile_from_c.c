/* Compiles a model in a C program, runs it with a callback that sees ports and values, asks why something is not
   possible, and proves it. */
#include <stdio.h>
#include <string.h>

#include "bip/compiler.h"

static const char* const kModel =
    "package lamp\n"
    "  port type Level(int level)\n"
    "  atom type Lamp()\n"
    "    data int level = 0\n"
    "    extern port Level turn(level) remember\n"
    "    port Level shine(level)\n"
    "    place OFF, LIT\n"
    "    initial to OFF\n"
    "    on turn from OFF to LIT eager\n"
    "    on shine from LIT to OFF provided (level > 2)\n"
    "  end\n"
    "  compound type Root()\n"
    "    component Lamp lamp()\n"
    "  end\n"
    "end\n";

static const char* const kCounter =
    "package counter\n"
    "  port type Signal()\n"
    "  atom type Counter()\n"
    "    data int n = 0\n"
    "    port Signal tick()\n"
    "    place S\n"
    "    initial to S\n"
    "    on tick from S to S provided (n < 5) do { n = n + 1; }\n"
    "  end\n"
    "  compound type Root()\n"
    "    component Counter c()\n"
    "  end\n"
    "end\n";

static void on_step(void* user, const bip_step_view* step) {
  printf("%llu: %s %s", (unsigned long long)step->number, step->interaction, step->ports[0]);
  for (size_t k = 0; k < step->value_count; ++k) printf(" %s = %d", step->values[k].name, step->values[k].value.is.as_int);
  printf("\n");
  *(int*)user += 1;
}

int main(void) {
  char text[2000];
  bip_model* wrong = bip_compile_text("package p\ncompound type Root()\n  component Missing m()\nend\nend\n", NULL, NULL);
  bip_diagnostic first;
  if (bip_model_image(wrong) != NULL || !bip_diagnostic_at(wrong, 0, &first)) return 1;
  printf("%s:%u:%u: %s: %s\n", first.file, first.line, first.column, first.code, first.message);
  bip_free_model(wrong);

  bip_model* model = bip_compile_text(kModel, NULL, "lamp.bip");
  bip_diagnostics(model, text, sizeof text);
  if (bip_model_image(model) == NULL) return fputs(text, stderr), 1;
  bip_options options = {0};
  options.size = sizeof options;
  options.policy = BIP_FAIR;
  bip_execution* system = bip_create_with(bip_model_image(model), &options);
  int steps = 0;
  bip_on_step_view(system, on_step, &steps);
  bip_value level = {BIP_INT, {.as_int = 2}};
  if (bip_post(system, "lamp.turn", &level, 1) != BIP_TAKEN || bip_post(system, "lamp.turn", NULL, 0) != BIP_BAD_VALUES ||
      bip_post(system, "lamp.off", NULL, 0) != BIP_NO_SUCH_PORT)
    return 1;
  bip_run(system, 10);
  bip_why(system, "lamp.shine", text, sizeof text);
  printf("%s", text);
  bip_destroy(system);

  bip_free_model(model);

  bip_model* counter = bip_compile_text(kCounter, NULL, NULL);
  const int verdict = bip_verify(counter, "never c.n > 2", 10);
  bip_verify_text(counter, text, sizeof text);
  printf("%s", text);
  const int nonsense = bip_verify(counter, "never c.nothing", 10);
  bip_free_model(counter);
  return steps == 1 && verdict == BIP_VIOLATED && nonsense == BIP_NOT_ANSWERED ? 0 : 1;
}
