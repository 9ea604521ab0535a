/* The C side of bip.hpp: the same Execution behind opaque handles. A bip_image is a bip::rt::Image; emitted programs
   hand theirs out as one. Texts are copied into the caller's buffer, cut to its size, always ended by a zero; the
   result is the length that the whole text has. A null buffer of size 0 asks for the length. */
#ifndef BIP_BIP_H
#define BIP_BIP_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct bip_image bip_image;
typedef struct bip_execution bip_execution;
typedef struct bip_snapshot bip_snapshot;

enum bip_policy { BIP_UNIFORM = 0, BIP_FIRST = 1, BIP_FAIR = 2 };
enum bip_outcome { BIP_STEPPED = 0, BIP_DEADLOCK = 1, BIP_FAULT = 2, BIP_STOPPED = 3 };

/* Null if the policy is none of the above. Ask bip_status whether the initial state is sound. */
bip_execution* bip_create(const bip_image* image, uint64_t seed, int policy);
void bip_destroy(bip_execution* system);

int bip_status(const bip_execution* system);
int bip_step(bip_execution* system);
uint64_t bip_run(bip_execution* system, uint64_t steps);
uint64_t bip_steps(const bip_execution* system);

uint64_t bip_candidate_count(const bip_execution* system);
size_t bip_candidate(const bip_execution* system, uint64_t k, char* buffer, size_t size);
int bip_fire(bip_execution* system, uint64_t k);

typedef void (*bip_callback)(void* user, uint64_t number, const char* interaction);
void bip_on_step(bip_execution* system, bip_callback callback, void* user);

/* 1: found; 0: no such variable of that type. Paths as "ROOT.a.x". */
int bip_read_int(const bip_execution* system, const char* path, int32_t* value);
int bip_read_bool(const bip_execution* system, const char* path, int* value);
int bip_read_float(const bip_execution* system, const char* path, double* value);
size_t bip_read_string(const bip_execution* system, const char* path, char* buffer, size_t size);
size_t bip_place(const bip_execution* system, const char* atom_path, char* buffer, size_t size);

bip_snapshot* bip_save(const bip_execution* system);
void bip_restore(bip_execution* system, const bip_snapshot* snapshot);
void bip_free_snapshot(bip_snapshot* snapshot);

size_t bip_fault(const bip_execution* system, char* buffer, size_t size);
size_t bip_story(const bip_execution* system, char* buffer, size_t size);

#ifdef __cplusplus
}
#endif
#endif
