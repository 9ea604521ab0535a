// Preloaded into a program: SIGTERM comes while a file is brought to the disk, so before it has its name.
#define _GNU_SOURCE
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

int fsync(int file) {
  kill(getpid(), SIGTERM);
  return (int)syscall(SYS_fsync, file);
}
