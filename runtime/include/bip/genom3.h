/* What C codels of GenoM 3 see of the run time: events, the context, sequences. Included by the headers that
 * `bipc genom --codels` writes; plain C, also for C++. */
#ifndef BIP_GENOM3_H
#define BIP_GENOM3_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a codel returns: a state, an exception, or genom_ok. */
typedef const char* genom_event;
#define genom_ok ((genom_event)0)

typedef const struct genom_context_if* genom_context;
struct genom_context_if {
  /* Raises an exception with its details, which are copied. Returns `ex`. */
  genom_event (*raise)(genom_event ex, const void* detail, size_t size, genom_context self);
  /* The details of the exception that was raised last; its event goes to `ex`. */
  const void* (*raised)(genom_event* ex, genom_context self);
  void* data;
  /* For C++ (bip/genom3.hpp): raises a genom::exception, which is copied. */
  genom_event (*raise_object)(const void* exception, genom_context self);
};

/* Room for `length` elements, the new ones zero; -1 if there is none. `_length` stays. A `sequence<T, n>` has its
 * elements in an array of `own` bytes, and no other room; they stay as they are. 0: it has memory of the heap. */
int genom_sequence_reserve_bytes(void* sequence, uint32_t length, size_t own, size_t element);
#define genom_sequence_reserve(sequence, length) \
  genom_sequence_reserve_bytes((sequence), (length), GENOM_OWN_BYTES(sequence), sizeof(*(sequence)->_buffer))

#ifdef __cplusplus
}
extern "C++" { /* also where this header is included with C linkage */
/* Bytes of `_buffer` if it is an array, 0 if it is a pointer. */
template <class T>
struct genom_own_bytes {
  static constexpr size_t value = 0;
};
template <class T, size_t n>
struct genom_own_bytes<T[n]> {
  static constexpr size_t value = sizeof(T[n]);
};
}
#define GENOM_OWN_BYTES(sequence) (genom_own_bytes<decltype((sequence)->_buffer)>::value)
#else
#define GENOM_OWN_BYTES(sequence)                                                                     \
  (__builtin_types_compatible_p(__typeof__((sequence)->_buffer), __typeof__(&(sequence)->_buffer[0])) \
       ? (size_t)0                                                                                    \
       : sizeof((sequence)->_buffer))
#endif
#endif
