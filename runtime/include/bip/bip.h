/* C interface of bip.hpp: the same Execution behind opaque handles.

   Texts are copied into the caller's buffer, truncated to its size and always terminated by a zero byte. Functions that
   copy a text return the length of the whole text without the zero byte; call them with a null buffer and size 0 to
   learn the length. Texts are UTF-8. Components are named by their paths, "ROOT.a"; variables by "ROOT.a.x".

   No function throws or aborts on a user's input. Handles must not be null unless a function says so. One execution
   must not be used by two threads at the same time; different executions are independent. */
#ifndef BIP_BIP_H
#define BIP_BIP_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The tables of a model: a bip::rt::Image. Emitted programs return theirs from image(). Immutable; may be shared. */
typedef struct bip_image bip_image;
/* A running model. */
typedef struct bip_execution bip_execution;
/* A saved state of an execution. */
typedef struct bip_snapshot bip_snapshot;

/* How the next step is chosen among the candidates: at random with equal probability, the first in canonical order, or
   the first after the interaction that was fired last (cyclically). */
enum bip_policy { BIP_UNIFORM = 0, BIP_FIRST = 1, BIP_FAIR = 2 };
/* Returns the number of the policy that --policy calls `name`, or -1 if the name is null or none: bip_create takes all
   policies of the command line, also those without a constant above. */
int bip_find_policy(const char* name);
/* How a call ended: a step was taken; there is no candidate; a run-time error, see bip_fault; the wait was ended. */
enum bip_outcome { BIP_STEPPED = 0, BIP_DEADLOCK = 1, BIP_FAULT = 2, BIP_STOPPED = 3, BIP_FINAL = 4 };

/* Creates an execution of `image` and initializes it: initial actions, then internal transitions. The image must
   outlive the execution. Returns null if the image is null or `policy` is no policy. If the initialization ends
   with a run-time error, bip_status returns BIP_FAULT. The caller owns the result: bip_destroy. Linear in the system.
 */
bip_execution* bip_create(const bip_image* image, uint64_t seed, int policy);
/* How bip_create_with creates an execution. Set everything to zero, then `size`: fields that later versions append are
   then zero for programs of today. */
typedef struct bip_options {
  size_t size; /* sizeof(bip_options) */
  uint64_t seed;
  int policy;
  int no_maximal_progress; /* not 0: an interaction does not have priority over those of the same connector that it
                              contains */
  int asap;     /* not 0: models with clocks take each step at the earliest instant at which it is possible */
  int strict;   /* with `speed`, not 0: a step that starts later than its guard allows is a fault */
  double speed; /* seconds of model time per second of the wall clock; 0: time passes without waiting */
  uint32_t event_capacity; /* greatest number of events that wait for one port; 0: 65536 */
} bip_options;
/* As bip_create. Also null if `options` is null, its size is unknown, or `speed` is not a number from 0 on. */
bip_execution* bip_create_with(const bip_image* image, const bip_options* options);
/* Destroys an execution; null is allowed. */
void bip_destroy(bip_execution* system);

/* Returns the bip_outcome of the last call that changed the execution; BIP_STEPPED after a successful bip_create. */
int bip_status(const bip_execution* system);
/* Takes one step that the policy chooses and returns its bip_outcome. In a model with clocks, time first passes to the
   instant of the step, without waiting. */
int bip_step(bip_execution* system);
/* Takes up to `steps` steps and returns how many were taken. If fewer, bip_status says why. */
uint64_t bip_run(bip_execution* system, uint64_t steps);
/* Returns the number of steps since bip_create, or since the start of the run that a restored snapshot belongs to. */
uint64_t bip_steps(const bip_execution* system);

/* Returns the number of candidates at this instant; 0 after a fault. In a model with clocks, 0 does not mean deadlock:
   candidates may appear when time passes. */
uint64_t bip_candidate_count(const bip_execution* system);
/* Copies the name of candidate k, "ROOT.connector" or "ROOT.a.port" for an internal port. Empty if k is not less than
   bip_candidate_count. */
size_t bip_candidate(const bip_execution* system, uint64_t k, char* buffer, size_t size);
/* Takes candidate k instead of asking the policy, and returns the bip_outcome. BIP_DEADLOCK if there is no candidate k.
 */
int bip_fire(bip_execution* system, uint64_t k);

/* Copies the ports that take part in candidate k, "ROOT.a.p", one a line. Empty if there is no candidate k. */
size_t bip_candidate_ports(const bip_execution* system, uint64_t k, char* buffer, size_t size);
/* Copies why an interaction or a port, by its path, is not possible now: lines, of which the first says whether it is.
   Empty if there is none of this name, and after a fault. */
size_t bip_why(const bip_execution* system, const char* path, char* buffer, size_t size);

/* Returns the model's instant in ns since the start; 0 in a model without clocks. */
int64_t bip_now(const bip_execution* system);
/* Returns the number of steps that started later than their guards allow (with `speed`). */
uint64_t bip_late_steps(const bip_execution* system);
/* With `speed`: aligns the wall clock with the model's instant, as after a pause. */
void bip_restart_clock(bip_execution* system);
/* Ends a bip_step that waits, and each one that would wait, with BIP_STOPPED, until bip_go_on. Any thread may call
   it. */
void bip_stop(bip_execution* system);
/* Ends the effect of bip_stop: further calls of bip_step wait again. Changes nothing without a bip_stop before it. Any
   thread may call it. */
void bip_go_on(bip_execution* system);

/* A value of an event or of a port's variable; `type` says which member holds it. */
enum bip_type { BIP_INT = 0, BIP_BOOL = 1, BIP_FLOAT = 2, BIP_STRING = 3 };
typedef struct bip_value {
  int type; /* a bip_type */
  union {
    int32_t as_int;
    int as_bool; /* 0 or 1 */
    double as_float;
    const char* as_string; /* UTF-8; copied by the functions that take a value */
  } is;
} bip_value;
/* What became of an event: it waits for the port; too many wait already; there is no `extern port` of this name; number
   or types of the values are not those of the port's type. */
enum bip_posted { BIP_TAKEN = 0, BIP_FULL = 1, BIP_NO_SUCH_PORT = 2, BIP_BAD_VALUES = 3 };
/* Posts an external event to an `extern port`, "ROOT.panel.turn" with or without "ROOT.", with one value for each
   variable of the port's type, and returns a bip_posted. Any thread may call it, also while another one is in bip_step.
   `values` may be null if `count` is 0. */
int bip_post(bip_execution* system, const char* port, const bip_value* values, size_t count);

/* Called after each step with its number, counted from 0, and the name of its interaction, which is valid during the
   call. */
typedef void (*bip_callback)(void* user, uint64_t number, const char* interaction);
/* Sets the callback, which is called with `user` on the thread that steps; a null callback removes it. Runs with a
   callback do not use compiled steps. */
void bip_on_step(bip_execution* system, bip_callback callback, void* user);

/* A step with its ports and their values as it was chosen. Everything is valid during the call only. */
typedef struct bip_port_value {
  size_t port;      /* row of `ports` */
  const char* name; /* of the variable in the port's type */
  bip_value value;  /* of a C++ type: its text */
} bip_port_value;
typedef struct bip_step_view {
  uint64_t number; /* counted from 0 */
  int64_t time;    /* instant in ns */
  const char* interaction;
  size_t port_count;
  const char* const* ports; /* "ROOT.p0.take", in the order of firing */
  size_t value_count;
  const bip_port_value* values;
} bip_step_view;
typedef void (*bip_step_callback)(void* user, const bip_step_view* step);
/* As bip_on_step, which it replaces: an execution has one callback. */
void bip_on_step_view(bip_execution* system, bip_step_callback callback, void* user);

/* Reads a variable of type int by its path, "ROOT.a.x". Returns 1 and sets *value, or returns 0 and leaves *value
   unchanged if there is no such variable of this type. Logarithmic in the number of atoms, linear in the variables of
   the atom. */
int bip_read_int(const bip_execution* system, const char* path, int32_t* value);
/* Reads a variable of type bool as 0 or 1; result, errors and cost as for bip_read_int. */
int bip_read_bool(const bip_execution* system, const char* path, int* value);
/* Reads a variable of type float; result, errors and cost as for bip_read_int. */
int bip_read_float(const bip_execution* system, const char* path, double* value);
/* Copies a variable of type string. Empty, too, if there is no such variable. */
size_t bip_read_string(const bip_execution* system, const char* path, char* buffer, size_t size);
/* Copies the place of an atom, or the marked places of a Petri net: "A, B". Empty if there is no such atom. */
size_t bip_place(const bip_execution* system, const char* atom_path, char* buffer, size_t size);

/* Saves state, number of steps and the policy's memory, so that a run continued from the snapshot repeats the run that
   followed it. The caller owns the result: bip_free_snapshot. Linear in the state. */
bip_snapshot* bip_save(const bip_execution* system);
/* Restores a snapshot of an execution of the same image. The snapshot is not changed and can be restored again. */
void bip_restore(bip_execution* system, const bip_snapshot* snapshot);
/* Destroys a snapshot; null is allowed. */
void bip_free_snapshot(bip_snapshot* snapshot);

/* Copies the text of the run-time error; empty if there is none. */
size_t bip_fault(const bip_execution* system, char* buffer, size_t size);
/* Copies the explanation of a deadlock (which component waits for which); empty if the state is not a deadlock. */
size_t bip_story(const bip_execution* system, char* buffer, size_t size);

#ifdef __cplusplus
}
#endif
#endif
