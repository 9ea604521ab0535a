// fail_system_call K PROGRAM ARGUMENT...: runs the program; the K-th of its system calls that can fail does (K = 0:
// none). Prints nothing; exit code and signal are the program's. With FAIL_COUNT=FILE the number of such calls is
// written to FILE; with FAIL_TELL the number of the call that fails is told.
//
// Calls are counted from the program's entry, in all its threads and not in programs that it starts: what the dynamic
// loader does before, and how it fails, is not the program's. What fails and how: no space for what is written, an I/O
// error for what is read, no descriptor for what is opened, no memory for what is mapped, no process or thread. Linux on
// x86-64, by ptrace.
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

// The error with which a call fails, or 0: it does not.
static int error_of(const struct user_regs_struct* regs) {
  switch (regs->orig_rax) {
    case SYS_write:
    case SYS_pwrite64:
    case SYS_writev:
      // What cannot be said on standard error is not said.
      return regs->rdi == 2 ? 0 : ENOSPC;
    case SYS_fsync:
    case SYS_read:
    case SYS_pread64:
    case SYS_getdents64:
    case SYS_unlink:
    case SYS_fstat:
    case SYS_newfstatat:
    case SYS_sendto:
    case SYS_recvmsg: return EIO;
    case SYS_rename:
    case SYS_mkdir: return ENOSPC;
    case SYS_open:
    case SYS_openat:
    case SYS_dup:
    case SYS_pipe2:
    case SYS_socket:
    case SYS_eventfd2:
    case SYS_timerfd_create:
    case SYS_epoll_create1: return EMFILE;
    case SYS_mmap:
    case SYS_mremap:
    case SYS_brk:
    case SYS_epoll_ctl: return ENOMEM;
    case SYS_clone:
    case SYS_clone3:
    case SYS_fork:
    case SYS_vfork: return EAGAIN;
    case SYS_bind:
    case SYS_listen:
    case SYS_fcntl: return EACCES;
    default: return 0;
  }
}

struct thread {
  pid_t id;
  int is_inside;   // of a system call
  int error;       // with which it ends; 0: as it does
  int is_foreign;  // a program that was started
  unsigned long long end_of_data;  // that was asked for and not given; 0: none
};
static struct thread threads[256];

static struct thread* thread_of(pid_t id) {
  struct thread* free = NULL;
  for (size_t k = 0; k < sizeof threads / sizeof *threads; ++k) {
    if (threads[k].id == id) return &threads[k];
    if (threads[k].id == 0 && free == NULL) free = &threads[k];
  }
  if (free == NULL) exit(98);
  *free = (struct thread){.id = id};
  return free;
}

static unsigned long seen = 0;

static void at_system_call(struct thread* thread, unsigned long which) {
  struct user_regs_struct regs;
  if (thread->is_foreign || ptrace(PTRACE_GETREGS, thread->id, 0, &regs) != 0) return;
  thread->is_inside = !thread->is_inside;
  if (thread->is_inside) {
    const int error = error_of(&regs);
    if (error == 0 || ++seen != which) return;
    if (regs.orig_rax == SYS_brk) {
      // It fails by not moving the end of the data.
      thread->end_of_data = regs.rdi;
      regs.rdi = 0;
      ptrace(PTRACE_SETREGS, thread->id, 0, &regs);
      return;
    }
    thread->error = error;
    if (getenv("FAIL_TELL") != NULL) fprintf(stderr, "system call %llu\n", regs.orig_rax);
    regs.orig_rax = (unsigned long long)-1;
  } else {
    if (thread->end_of_data != 0) {
      // Programs rely on it that arguments stay in their registers.
      regs.rdi = thread->end_of_data;
      thread->end_of_data = 0;
      ptrace(PTRACE_SETREGS, thread->id, 0, &regs);
    }
    if (thread->error == 0) return;
    regs.rax = (unsigned long long)-thread->error;
    thread->error = 0;
  }
  ptrace(PTRACE_SETREGS, thread->id, 0, &regs);
}

// The address of the program's first instruction; 0: not known.
static unsigned long entry_of(pid_t id) {
  char path[32];
  snprintf(path, sizeof path, "/proc/%d/auxv", (int)id);
  FILE* file = fopen(path, "rb");
  if (file == NULL) return 0;
  Elf64_auxv_t pair;
  unsigned long entry = 0;
  while (entry == 0 && fread(&pair, sizeof pair, 1, file) == 1) entry = pair.a_type == AT_ENTRY ? pair.a_un.a_val : 0;
  fclose(file);
  return entry;
}

// A breakpoint where the program begins (0: none is set), and the instruction that stands there.
static unsigned long entry = 0;
static long first_instruction = 0;

static void stop_at_entry(pid_t id) {
  entry = entry_of(id);
  if (entry == 0) exit(99);
  first_instruction = ptrace(PTRACE_PEEKTEXT, id, entry, 0);
  ptrace(PTRACE_POKETEXT, id, entry, (first_instruction & ~0xffL) | 0xcc);
}

// Whether the thread stands behind that breakpoint, which is then gone.
static int is_at_entry(pid_t id) {
  struct user_regs_struct regs;
  if (entry == 0 || ptrace(PTRACE_GETREGS, id, 0, &regs) != 0 || regs.rip != entry + 1) return 0;
  ptrace(PTRACE_POKETEXT, id, entry, first_instruction);
  regs.rip = entry;
  ptrace(PTRACE_SETREGS, id, 0, &regs);
  entry = 0;
  return 1;
}

static void write_count(void) {
  const char* path = getenv("FAIL_COUNT");
  FILE* file = path != NULL ? fopen(path, "w") : NULL;
  if (file == NULL) return;
  fprintf(file, "%lu\n", seen);
  fclose(file);
}

int main(int argc, char** argv) {
  if (argc < 3) return 97;
  const unsigned long which = strtoul(argv[1], NULL, 10);
  const pid_t program = fork();
  if (program == 0) {
    ptrace(PTRACE_TRACEME, 0, 0, 0);
    raise(SIGSTOP);
    execvp(argv[2], argv + 2);
    _exit(127);
  }
  int status = 0;
  if (program < 0 || waitpid(program, &status, 0) != program) return 97;
  ptrace(PTRACE_SETOPTIONS, program, 0,
         PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK | PTRACE_O_TRACEEXEC |
             PTRACE_O_EXITKILL);
  thread_of(program)->is_foreign = 1;  // until the program begins
  ptrace(PTRACE_SYSCALL, program, 0, 0);
  int has_begun = 0;
  for (;;) {
    const pid_t id = waitpid(-1, &status, __WALL);
    if (id < 0) return 97;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      thread_of(id)->id = 0;
      if (id != program) continue;
      write_count();
      if (WIFSIGNALED(status)) {
        signal(WTERMSIG(status), SIG_DFL);
        kill(getpid(), WTERMSIG(status));
      }
      return WEXITSTATUS(status);
    }
    struct thread* thread = thread_of(id);
    const int what = WSTOPSIG(status);
    int deliver = 0;
    if (what == (SIGTRAP | 0x80)) at_system_call(thread, which);
    else if (what != SIGTRAP) deliver = what == SIGSTOP ? 0 : what;
    else if (status >> 16 == PTRACE_EVENT_EXEC && id == program && !has_begun) stop_at_entry(id);
    else if (status >> 16 == PTRACE_EVENT_EXEC) thread->is_foreign = 1;
    else if (id == program && is_at_entry(id)) thread->is_foreign = 0, has_begun = 1;
    ptrace(PTRACE_SYSCALL, id, 0, deliver);
  }
}
