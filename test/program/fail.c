/* SPDX-License-Identifier: MIT */
/* Makes one call of the running program fail, to prove that the program then has the right result
 * or none. LD_PRELOAD loads this library before the C library. It counts calls from the start of
 * main, in each process by itself. FAIL says what happens:
 *
 *   (not set)     nothing fails; calls are counted
 *   KIND:N        the Nth call of this kind fails
 *   KIND:N+       the Nth call and all later ones fail
 *   KIND:N:E      as above, with the error number E instead of the usual one
 *   eintr:N       every Nth call that a signal may interrupt fails with EINTR
 *   short:N       every Nth read and write moves only a half
 *
 * The last two spare dlopen: the loader of the C library takes neither for what it is.
 *
 * A KIND is `own` (an allocation of the program, of libtiff or of a library that libtiff uses),
 * `gl` (an allocation of any other library), `thread` (a start of a thread), `fork`, or a system
 * call in `calls` below. An allocation in the C library belongs to the library that called the C
 * library. System calls of all libraries count, the C library's own ones too: the kernel's seccomp
 * filter turns each into a signal, whose handler makes the call or refuses it.
 *
 * FAIL_DEPTH restricts failures to processes of one generation: 0 is the first process, 1 its
 * children. With FAIL_NAMELESS no file system keeps files without a name (O_TMPFILE). FAIL_REPORT
 * names a file of sizeof(struct report) bytes, which test/program/attacked.py reads. It receives
 * the counts. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>
#include <unwind.h>

#include "test/shared/preload.h"

enum { OWN, GL, THREAD, FORK, CALLS }; /* kinds; then the rows of calls */
static const char *const kinds[CALLS] = {"own", "gl", "thread", "fork"};
enum { KINDS = 64, PROCESSES = 64, OBJECTS = 128, NAME = 16 };

/* flags of a system call */
enum { INTERRUPTIBLE = 1, MOVES_BYTES = 2, DONE_ANYWAY = 4 };

/* Several numbers of system calls may have one name; the first one counts for all. */
static const struct call {
    const char *name;
    long number;
    int usual_error, flags;
} calls[] = {
    {"open", SYS_openat, EMFILE, INTERRUPTIBLE},
    {"read", SYS_read, EIO, INTERRUPTIBLE | MOVES_BYTES},
    {"pread", SYS_pread64, EIO, INTERRUPTIBLE | MOVES_BYTES},
    {"write", SYS_write, ENOSPC, INTERRUPTIBLE | MOVES_BYTES},
    {"pwrite", SYS_pwrite64, ENOSPC, INTERRUPTIBLE | MOVES_BYTES},
    {"lseek", SYS_lseek, EIO, 0},
    {"close", SYS_close, EIO, DONE_ANYWAY},
    {"stat", SYS_newfstatat, EIO, 0},
    {"statx", SYS_statx, EIO, 0},
    {"statfs", SYS_fstatfs, EIO, 0},
    {"access", SYS_faccessat, EIO, 0},
    {"faccessat", SYS_faccessat2, EIO, 0},
    {"readlink", SYS_readlinkat, EIO, 0},
    {"getcwd", SYS_getcwd, ENOMEM, 0},
    {"getdents", SYS_getdents64, EIO, 0},
    {"mmap", SYS_mmap, ENOMEM, 0},
    {"mremap", SYS_mremap, ENOMEM, 0},
    {"mprotect", SYS_mprotect, ENOMEM, 0},
    {"ftruncate", SYS_ftruncate, EIO, INTERRUPTIBLE},
    {"fallocate", SYS_fallocate, ENOSPC, INTERRUPTIBLE},
    {"fsync", SYS_fsync, EIO, INTERRUPTIBLE},
    {"rename", SYS_renameat2, EIO, 0},
    {"link", SYS_linkat, ENOSPC, 0},
    {"unlink", SYS_unlinkat, EIO, 0},
    {"mkdir", SYS_mkdirat, ENOSPC, 0},
    {"chmod", SYS_fchmod, EIO, 0},
    {"fcntl", SYS_fcntl, EMFILE, INTERRUPTIBLE},
    {"ioctl", SYS_ioctl, EIO, 0},
    {"dup", SYS_dup, EMFILE, 0},
    {"dup3", SYS_dup3, EMFILE, 0},
    {"pipe", SYS_pipe2, EMFILE, 0},
    {"wait", SYS_wait4, ECHILD, INTERRUPTIBLE},
    {"poll", SYS_ppoll, ENOMEM, INTERRUPTIBLE},
    {"prlimit", SYS_prlimit64, EPERM, 0},
    {"affinity", SYS_sched_getaffinity, EINVAL, 0},
    {"random", SYS_getrandom, ENOSYS, INTERRUPTIBLE},
    {"socket", SYS_socket, EMFILE, 0},
    {"memfd", SYS_memfd_create, ENOSYS, 0},
#ifdef SYS_open
    {"open", SYS_open, EMFILE, INTERRUPTIBLE},
    {"stat", SYS_stat, EIO, 0},
    {"stat", SYS_lstat, EIO, 0},
    {"access", SYS_access, EIO, 0},
    {"readlink", SYS_readlink, EIO, 0},
    {"rename", SYS_rename, EIO, 0},
    {"link", SYS_link, ENOSPC, 0},
    {"unlink", SYS_unlink, EIO, 0},
    {"unlink", SYS_rmdir, EIO, 0},
    {"mkdir", SYS_mkdir, ENOSPC, 0},
    {"pipe", SYS_pipe, EMFILE, 0},
    {"dup3", SYS_dup2, EMFILE, 0},
    {"poll", SYS_poll, ENOMEM, INTERRUPTIBLE},
#endif
    {"stat", SYS_fstat, EIO, 0},
    {"statfs", SYS_statfs, EIO, 0},
    {"fsync", SYS_fdatasync, EIO, INTERRUPTIBLE},
    {"rename", SYS_renameat, EIO, 0},
};
enum { N_CALLS = sizeof calls / sizeof *calls };

struct report {
    char names[KINDS][NAME];
    uint64_t n_processes; /* as many as were started, even if more than PROCESSES */
    struct process {
        uint64_t depth, counts[KINDS];
    } processes[PROCESSES];
};

static struct object {
    const char *name;
    uintptr_t begin, end;
    int kind; /* OWN, GL, or -1 for libraries that work for others */
} objects[OBJECTS];
static int n_objects;

static struct attack {
    bool on_calls, later, storm, cuts;
    bool nameless; /* files without a name are refused */
    int kind, error;
    long depth; /* -1: all */
    uint64_t n;
} attack;

static struct report nowhere, *report = &nowhere;
static struct process *self;
static bool counts; /* from the start of main */

/* ---- the way back to the caller ---- */

static void add_object(const char *path, uintptr_t begin, uintptr_t end)
{
    static const char *const own[] = {"spectral", "libtiff.",   "libz.",    "libzstd.",
                                      "libwebp.", "liblzma.",   "libLerc.", "libjbig.",
                                      "libjpeg.", "libdeflate."};
    static const char *const servants[] = {"libc.", "ld-linux", "fail.so"};
    const char *slash = strrchr(path, '/');
    struct object *object = &objects[n_objects++];
    *object = (struct object){*path ? slash ? slash + 1 : path : "spectral", begin, end, GL};
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (strncmp(object->name, own[i], strlen(own[i])) == 0)
            object->kind = OWN;
    for (size_t i = 0; i < sizeof servants / sizeof *servants; i++)
        if (strncmp(object->name, servants[i], strlen(servants[i])) == 0)
            object->kind = -1;
}

static int note_object(struct dl_phdr_info *info, size_t size, void *context)
{
    uintptr_t begin = UINTPTR_MAX, end = 0;
    (void)size;
    (void)context;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const uintptr_t from = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
        if (info->dlpi_phdr[i].p_type != PT_LOAD)
            continue;
        begin = from < begin ? from : begin;
        end = from + info->dlpi_phdr[i].p_memsz > end ? from + info->dlpi_phdr[i].p_memsz : end;
    }
    if (n_objects < OBJECTS)
        add_object(info->dlpi_name, begin, end);
    return 0;
}

/* Code outside of all objects was made by a driver. */
static int kind_at(uintptr_t address)
{
    for (int i = 0; i < n_objects; i++)
        if (address >= objects[i].begin && address < objects[i].end)
            return objects[i].kind;
    return GL;
}

static _Unwind_Reason_Code find_kind(struct _Unwind_Context *frame, void *kind)
{
    *(int *)kind = kind_at(_Unwind_GetIP(frame));
    return *(int *)kind < 0 ? _URC_NO_REASON : _URC_NORMAL_STOP;
}

static int kind_of_caller(void *address)
{
    int kind = kind_at((uintptr_t)address);
    if (kind < 0)
        _Unwind_Backtrace(find_kind, &kind);
    return kind < 0 ? GL : kind;
}

/* ---- counting ---- */

/* Counts a call; returns whether it must fail. */
static bool strikes(int kind)
{
    if (!counts)
        return false;
    const uint64_t n = __atomic_add_fetch(&self->counts[kind], 1, __ATOMIC_RELAXED);
    if (kind != attack.kind || (attack.depth >= 0 && self->depth != (uint64_t)attack.depth))
        return false;
    return attack.storm ? n % attack.n == 0 : attack.later ? n >= attack.n : n == attack.n;
}

static void begin_process(uint64_t depth)
{
    const uint64_t i = __atomic_fetch_add(&report->n_processes, 1, __ATOMIC_RELAXED);
    self = &report->processes[i < PROCESSES ? i : PROCESSES - 1];
    self->depth = depth;
}

static void begin_child(void)
{
    begin_process(self->depth + 1);
}

/* ---- allocations ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static bool no_memory(void *caller)
{
    if (!counts || !strikes(kind_of_caller(caller)))
        return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t size)
{
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t size)
{
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size);
}

void *reallocarray(void *old, size_t n, size_t size)
{
    if (size != 0 && n > SIZE_MAX / size) {
        errno = ENOMEM;
        return NULL;
    }
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_realloc(old, n * size);
}

void *memalign(size_t alignment, size_t size);
void *memalign(size_t alignment, size_t size)
{
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return no_memory(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    const int before = errno;
    void *memory = no_memory(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
    errno = before; /* as posix_memalign leaves it */
    if (!memory)
        return ENOMEM;
    *out = memory;
    return 0;
}

/* ---- libraries ---- */

static __thread int loading; /* libraries that this thread is opening */

void *dlopen(const char *file, int mode)
{
    loading++;
    void *library = REAL(dlopen)(file, mode);
    loading--;
    return library;
}

/* ---- threads and processes ---- */

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *),
                   void *context)
{
    return strikes(THREAD) ? EAGAIN : REAL(pthread_create)(thread, attributes, start, context);
}

pid_t fork(void)
{
    if (!strikes(FORK))
        return REAL(fork)();
    errno = EAGAIN;
    return -1;
}

/* The program that this process becomes belongs to the same generation. */
int execvp(const char *file, char *const words[])
{
    char generation[24];
    counts = false;
    snprintf(generation, sizeof generation, "%llu", (unsigned long long)self->depth);
    setenv("FAIL_GENERATION", generation, 1);
    return REAL(execvp)(file, words);
}

/* ---- system calls ---- */

#ifndef __x86_64__
#error "this needs the system call instruction of this processor"
#endif

/* The filter lets the call of this function pass, by the address behind its instruction. */
long fail_call(long number, long a, long b, long c, long d, long e, long f);
extern char fail_called[];
__asm__(".text\n"
        ".hidden fail_call, fail_called\n"
        ".globl fail_call, fail_called\n"
        "fail_call:\n"
        "    mov %rdi, %rax\n"
        "    mov %rsi, %rdi\n"
        "    mov %rdx, %rsi\n"
        "    mov %rcx, %rdx\n"
        "    mov %r8, %r10\n"
        "    mov %r9, %r8\n"
        "    mov 8(%rsp), %r9\n"
        "    syscall\n"
        "fail_called:\n"
        "    ret\n");

static int row_of(long number)
{
    for (int i = 0; i < N_CALLS; i++)
        if (calls[i].number == number)
            return i;
    return 0; /* never: the filter has the same list */
}

/* Several rows may have one name. */
static int first_row(const char *name)
{
    int i = 0;
    while (i < N_CALLS && strcmp(calls[i].name, name) != 0)
        i++;
    return i;
}

/* A message that cannot be printed is no failure of the program. */
static bool is_message(const struct call *call, const greg_t *registers)
{
    return call->number == SYS_write && registers[REG_RDI] == STDERR_FILENO;
}

/* Returns whether the call wants a file without a name. */
static bool is_nameless(const struct call *call, const greg_t *registers)
{
    const greg_t flags = registers[call->number == SYS_openat ? REG_RDX : REG_RSI];
    return strcmp(call->name, "open") == 0 && (flags & O_TMPFILE) == O_TMPFILE;
}

static long answer(const struct call *call, const greg_t *registers)
{
    if (attack.nameless && is_nameless(call, registers))
        return -EOPNOTSUPP;
    const int kind = CALLS + first_row(call->name);
    const long failure = -(attack.error ? attack.error : call->usual_error);
    greg_t length = registers[REG_RDX];
    bool fails = false;
    if (!is_message(call, registers)) {
        const bool counted = strikes(kind);
        if (!attack.storm)
            fails = counted;
        else if (!loading && call->flags & (attack.cuts ? MOVES_BYTES : INTERRUPTIBLE))
            fails = strikes(attack.kind);
    }
    if (fails && attack.cuts)
        length = (length + 1) / 2;
    else if (fails && !(call->flags & DONE_ANYWAY))
        return failure;
    const long result = fail_call(call->number, registers[REG_RDI], registers[REG_RSI], length,
                                  registers[REG_R10], registers[REG_R8], registers[REG_R9]);
    return fails && !attack.cuts ? failure : result;
}

static void on_call(int number, siginfo_t *info, void *context)
{
    greg_t *registers = ((ucontext_t *)context)->uc_mcontext.gregs;
    (void)number;
    registers[REG_RAX] = answer(&calls[row_of(info->si_syscall)], registers);
}

static struct sock_filter load(size_t offset)
{
    return (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, (uint32_t)offset);
}

/* Jumps by a comparison with the value: BPF_JEQ, equal, or BPF_JGE, at least. */
static struct sock_filter jump(int comparison, uint32_t value, int to, int otherwise)
{
    return (struct sock_filter)BPF_JUMP((uint16_t)(BPF_JMP | comparison | BPF_K), value,
                                        (uint8_t)to, (uint8_t)otherwise);
}

/* The libraries that make system calls. */
static const char *const callers[] = {"libc.", "ld-linux"};
enum { CALLERS = sizeof callers / sizeof *callers, CALLER_STEPS = 5 };

/* Jumps behind the next steps and one more if the call comes from a library, to the next step if it
 * does not. A program that this process becomes has its libraries elsewhere: there the filter,
 * which stays in force, lets all calls pass. The next program adds a filter of its own. */
static void filter_caller(int caller, struct sock_filter *out)
{
    uintptr_t begin = 0, end = 0;
    for (int i = 0; i < n_objects; i++)
        if (strncmp(objects[i].name, callers[caller], strlen(callers[caller])) == 0) {
            begin = objects[i].begin;
            end = objects[i].end;
        }
    if (end >> 32 != begin >> 32) /* a jump compares the lower half of an address */
        end = begin | UINT32_MAX;
    out[0] = load(offsetof(struct seccomp_data, instruction_pointer) + 4);
    out[1] = jump(BPF_JEQ, (uint32_t)(begin >> 32), 0, 3);
    out[2] = load(offsetof(struct seccomp_data, instruction_pointer));
    out[3] = jump(BPF_JGE, (uint32_t)begin, 0, 1);
    out[4] = jump(BPF_JGE, (uint32_t)end, 0, (CALLERS - 1 - caller) * CALLER_STEPS + 1);
}

/* Traps the system calls of `calls`, unless the attack needs only some of them. */
static bool is_trapped(const struct call *call)
{
    if (attack.nameless && strcmp(call->name, "open") == 0)
        return true;
    if (!attack.on_calls)
        return attack.n == 0;
    return attack.storm ? call->flags & (attack.cuts ? MOVES_BYTES : INTERRUPTIBLE)
                        : CALLS + first_row(call->name) == attack.kind;
}

static void filter_calls(void)
{
    const uint64_t own = (uintptr_t)fail_called;
    struct sock_filter filter[2 * N_CALLS + CALLERS * CALLER_STEPS + 9];
    int n = 0;
    filter[n++] = load(offsetof(struct seccomp_data, instruction_pointer));
    filter[n++] = jump(BPF_JEQ, (uint32_t)own, 0, 3);
    filter[n++] = load(offsetof(struct seccomp_data, instruction_pointer) + 4);
    filter[n++] = jump(BPF_JEQ, (uint32_t)(own >> 32), 0, 1);
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    for (int i = 0; i < CALLERS; i++, n += CALLER_STEPS)
        filter_caller(i, filter + n);
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    filter[n++] = load(offsetof(struct seccomp_data, nr));
    for (int i = 0; i < N_CALLS; i++) {
        if (!is_trapped(&calls[i]))
            continue;
        filter[n++] = jump(BPF_JEQ, (uint32_t)calls[i].number, 0, 1);
        filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
    }
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    /* another handler would make calls while the trap is blocked, which ends the process */
    struct sigaction on_trap = {.sa_sigaction = on_call, .sa_flags = SA_SIGINFO};
    sigfillset(&on_trap.sa_mask);
    const struct sock_fprog program = {(unsigned short)n, filter};
    if (sigaction(SIGSYS, &on_trap, NULL) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
        abort();
}

/* ---- start ---- */

static int kind_named(const char *name)
{
    for (int i = 0; i < CALLS; i++)
        if (strcmp(name, kinds[i]) == 0)
            return i;
    return CALLS + first_row(name);
}

static void read_attack(const char *words)
{
    const char *depth = getenv("FAIL_DEPTH");
    char name[NAME] = "", *rest;
    sscanf(words, "%15[^:]", name);
    attack.cuts = strcmp(name, "short") == 0;
    attack.storm = attack.cuts || strcmp(name, "eintr") == 0;
    attack.kind = attack.storm ? KINDS - 1 : kind_named(name);
    attack.on_calls = attack.kind >= CALLS;
    attack.depth = depth ? atol(depth) : -1;
    attack.n = strtoull(words + strlen(name) + 1, &rest, 10);
    attack.later = *rest == '+';
    rest += attack.later;
    attack.error = attack.storm ? EINTR : *rest == ':' ? atoi(rest + 1) : 0;
    if (attack.n == 0 || (!attack.storm && attack.kind >= CALLS + N_CALLS))
        abort();
}

static void open_report(const char *path)
{
    const int file = open(path, O_RDWR | O_CLOEXEC);
    void *memory = mmap(NULL, sizeof *report, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (file < 0 || memory == MAP_FAILED)
        abort();
    close(file);
    report = memory;
    for (int i = 0; i < CALLS; i++)
        strcpy(report->names[i], kinds[i]);
    for (int i = 0; i < N_CALLS; i++)
        if (first_row(calls[i].name) == i)
            strcpy(report->names[CALLS + i], calls[i].name);
}

static int (*next_main)(int, char **, char **);

static int begin_main(int n, char **words, char **environment)
{
    if (getenv("FAIL_REPORT"))
        open_report(getenv("FAIL_REPORT"));
    if (getenv("FAIL"))
        read_attack(getenv("FAIL"));
    else
        attack.kind = -1;
    dl_iterate_phdr(note_object, NULL);
    attack.nameless = getenv("FAIL_NAMELESS") != NULL;
    const char *generation = getenv("FAIL_GENERATION");
    begin_process(generation ? strtoull(generation, NULL, 10) : 0);
    pthread_atfork(NULL, NULL, begin_child);
    if (attack.on_calls || attack.nameless || attack.kind < 0)
        filter_calls();
    counts = true;
    return next_main(n, words, environment);
}

int __libc_start_main(int (*start)(int, char **, char **), int n, char **words, void (*init)(void),
                      void (*fini)(void), void (*rtld_fini)(void), void *stack_end);
int __libc_start_main(int (*start)(int, char **, char **), int n, char **words, void (*init)(void),
                      void (*fini)(void), void (*rtld_fini)(void), void *stack_end)
{
    next_main = start;
    return REAL(__libc_start_main)(begin_main, n, words, init, fini, rtld_fini, stack_end);
}
