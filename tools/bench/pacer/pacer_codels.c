/* Codels of the benchmark `rate`, as people write them for genom3. Each cycle of the task notes when it began and how
 * long it took; `report` writes that, pairs of 64-bit nanoseconds, to a file. A program of `bipc build` has no clients:
 * it writes the file of $PACER_OUT at its end. */
#include "acpacer.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "pacer_c_types.h"

enum { kMost = 2000000 };
struct pacer_record_s {
  uint64_t count;
  struct {
    uint64_t begun, took;
  } cycles[kMost];
};
static pacer_record_s *last_record;

static uint64_t now_ns(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static int write_record(const pacer_record_s *record, const char *path)
{
  FILE *const file = fopen(path, "wb");
  const int is_sound =
    file && fwrite(record->cycles, sizeof(record->cycles[0]), record->count, file) == record->count;
  return file && fclose(file) == 0 && is_sound ? 0 : -1;
}

__attribute__((destructor)) static void write_at_exit(void)
{
  const char *const path = getenv("PACER_OUT");
  if (path && last_record) write_record(last_record, path);
}

genom_event
pacerStart(pacer_ids *ids, const pacer_state *state, const genom_context self)
{
  int k;
  ids->record = malloc(sizeof(*ids->record));
  if (!ids->record) return pacer_ether;
  /* No page is touched first in a cycle that counts. */
  memset(ids->record, 0xff, sizeof(*ids->record));
  ids->record->count = 0;
  last_record = ids->record;
  for (k = 0; k < pacer_axes; k++) {
    ids->measured.position[k] = ids->measured.velocity[k] = 0.;
    ids->desired.position[k] = 1. + k;
    ids->desired.velocity[k] = 0.;
  }
  *state->data(self) = ids->measured;
  state->write(self);
  return pacer_control;
}

/* A point mass in three axes under a controller with a limit, as a drone's position loop. */
genom_event
pacerControl(const pacer_motion *desired, pacer_motion *measured, pacer_record_s **record,
             const pacer_state *state, const genom_context self)
{
  const uint64_t begun = now_ns();
  const double dt = pacer_period_us * 1e-6;
  double force[3], size = 0.;
  int k;
  for (k = 0; k < pacer_axes; k++) {
    force[k] = 6. * (desired->position[k] - measured->position[k]) +
               4. * (desired->velocity[k] - measured->velocity[k]);
    size += force[k] * force[k];
  }
  size = sqrt(size);
  for (k = 0; k < pacer_axes; k++) {
    measured->velocity[k] += dt * (size > 5. ? force[k] * 5. / size : force[k]);
    measured->position[k] += dt * measured->velocity[k];
  }
  *state->data(self) = *measured;
  state->write(self);
  if ((*record)->count < kMost) {
    (*record)->cycles[(*record)->count].begun = begun;
    (*record)->cycles[(*record)->count++].took = now_ns() - begun;
  }
  return pacer_pause_control;
}

genom_event
pacerStop(pacer_record_s **record, const genom_context self)
{
  (void)self;
  last_record = NULL;
  free(*record);
  *record = NULL;
  return pacer_ether;
}

genom_event
pacerReport(const char *path, const pacer_record_s *record, uint64_t *cycles, const genom_context self)
{
  pacer_e_file_detail d;
  *cycles = record->count;
  if (write_record(record, path) == 0) return genom_ok;
  d.code = (int16_t)errno;
  return pacer_e_file(&d, self);
}

genom_event
holdStart(uint32_t cycles, uint32_t *left, const genom_context self)
{
  (void)self;
  *left = cycles;
  return pacer_wait;
}

genom_event
holdWait(uint32_t *left, const genom_context self)
{
  (void)self;
  return *left && --*left ? pacer_pause_wait : pacer_ether;
}
