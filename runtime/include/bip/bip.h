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

/* Called after each step with its number, counted from 0, and the name of its interaction, which is valid during the
   call. */
typedef void (*bip_callback)(void* user, uint64_t number, const char* interaction);
/* Sets the callback, which is called with `user` on the thread that steps; a null callback removes it. Runs with a
   callback do not use compiled steps. */
void bip_on_step(bip_execution* system, bip_callback callback, void* user);

/* Read a variable of an atom, by its path. Return 1 and set *value, or return 0 and leave *value unchanged if there is
   no such variable of this type. */
int bip_read_int(const bip_execution* system, const char* path, int32_t* value);
/* *value is 0 or 1. */
int bip_read_bool(const bip_execution* system, const char* path, int* value);
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
