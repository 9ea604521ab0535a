/* What the machine gives: a loop of 1 kHz that only sleeps until its next cycle is due and notes when it began. The
 * record is that of pacer_codels.c. Arguments: the file, the number of cycles, a priority of SCHED_FIFO (0: none). */
#define _GNU_SOURCE
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>

static uint64_t now_ns(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

int main(int argc, char **argv)
{
  const long count = argc > 2 ? atol(argv[2]) : 1000;
  const struct sched_param priority = {argc > 3 ? atoi(argv[3]) : 0};
  uint64_t *const record = malloc((size_t)count * 2 * sizeof(*record));
  FILE *file;
  uint64_t due;
  long k;
  if (!record || argc < 2) return 1;
  memset(record, 0xff, (size_t)count * 2 * sizeof(*record));
  prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
  if (priority.sched_priority && sched_setscheduler(0, SCHED_FIFO, &priority)) perror("bare: no real-time priority");
  due = now_ns();
  for (k = 0; k < count; k++) {
    struct timespec at;
    due += 1000000;
    at.tv_sec = (time_t)(due / 1000000000u);
    at.tv_nsec = (long)(due % 1000000000u);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL)) {
    }
    record[2 * k] = now_ns();
    record[2 * k + 1] = now_ns() - record[2 * k];
  }
  file = fopen(argv[1], "wb");
  return file && fwrite(record, 2 * sizeof(*record), (size_t)count, file) == (size_t)count && fclose(file) == 0 ? 0 : 1;
}
