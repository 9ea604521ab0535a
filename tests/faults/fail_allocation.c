// Preloaded into a program: its k-th allocation fails (FAIL_ALLOCATION=k), or that and all later ones
// (FAIL_ALLOCATION=k+). With FAIL_COUNT=FILE the number of allocations is written to FILE at the end instead.
//
// Allocations of the dynamic linker are not seen. The functions of the C library that allocate call malloc, so they are.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* old, size_t size);
extern void* __libc_memalign(size_t alignment, size_t size);

static atomic_ulong seen;
static unsigned long first;
static int for_ever;
static int is_ready;

__attribute__((constructor)) static void begin(void) {
  const char* which = getenv("FAIL_ALLOCATION");
  if (which != NULL) {
    char* end = NULL;
    first = strtoul(which, &end, 10);
    for_ever = *end == '+';
  }
  is_ready = 1;
}

__attribute__((destructor)) static void end(void) {
  const char* path = getenv("FAIL_COUNT");
  if (path == NULL) return;
  char text[32];
  const int size = snprintf(text, sizeof text, "%lu\n", (unsigned long)seen);
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || write(file, text, (size_t)size) != size) _exit(99);
  close(file);
}

static int fails(void) {
  if (!is_ready) return 0;
  const unsigned long number = atomic_fetch_add(&seen, 1) + 1;
  if (first == 0 || number < first || (number > first && !for_ever)) return 0;
  errno = ENOMEM;
  return 1;
}

void* malloc(size_t size) { return fails() ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails() ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails() ? NULL : __libc_realloc(old, size); }
void* memalign(size_t alignment, size_t size) { return fails() ? NULL : __libc_memalign(alignment, size); }
void* aligned_alloc(size_t alignment, size_t size) { return fails() ? NULL : __libc_memalign(alignment, size); }
int posix_memalign(void** to, size_t alignment, size_t size) {
  void* made = fails() ? NULL : __libc_memalign(alignment, size);
  if (made == NULL) return ENOMEM;
  *to = made;
  return 0;
}
