/* A disk that fails: the n-th write, sync, rename or link below a folder gives an error. Loaded before the C library. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;

static long number(const char *name) {
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

/* Whether a file, by its handle or name, lies where the disk fails. */
static int there(int handle, const char *name) {
    const char *folder = getenv("FAILING_FOLDER");
    char link[64], held[PATH_MAX];
    if (!folder) return 0;
    if (name) {
        if (name[0] == '/') return strncmp(name, folder, strlen(folder)) == 0;
        if (!getcwd(held, sizeof held)) return 0;
        return strncmp(held, folder, strlen(folder)) == 0;
    }
    snprintf(link, sizeof link, "/proc/self/fd/%d", handle);
    ssize_t length = readlink(link, held, sizeof held - 1);
    if (length < 0) return 0;
    held[length] = 0;
    return strncmp(held, folder, strlen(folder)) == 0;
}

static int fails(int handle, const char *name) {
    if (!there(handle, name)) return 0;
    long at = atomic_fetch_add(&calls, 1) + 1;
    long first = number("FAILING_AT");
    if (first == 0 || at < first || (at > first && !number("FAILING_ON"))) return 0;
    errno = (int)number("FAILING_ERROR");
    return 1;
}

#define REAL(name) static __typeof__(name) *real; if (!real) real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

ssize_t write(int f, const void *b, size_t n) { REAL(write); return fails(f, 0) ? -1 : real(f, b, n); }
ssize_t writev(int f, const struct iovec *v, int n) { REAL(writev); return fails(f, 0) ? -1 : real(f, v, n); }
ssize_t pwrite(int f, const void *b, size_t n, off_t o) { REAL(pwrite); return fails(f, 0) ? -1 : real(f, b, n, o); }
ssize_t pwrite64(int f, const void *b, size_t n, off64_t o) { REAL(pwrite64); return fails(f, 0) ? -1 : real(f, b, n, o); }
int fsync(int f) { REAL(fsync); return fails(f, 0) ? -1 : real(f); }
int fdatasync(int f) { REAL(fdatasync); return fails(f, 0) ? -1 : real(f); }
int rename(const char *a, const char *b) { REAL(rename); return fails(-1, b) ? -1 : real(a, b); }
int renameat(int d, const char *a, int e, const char *b) { REAL(renameat); return fails(-1, b) ? -1 : real(d, a, e, b); }
int link(const char *a, const char *b) { REAL(link); return fails(-1, b) ? -1 : real(a, b); }
int linkat(int d, const char *a, int e, const char *b, int g) { REAL(linkat); return fails(-1, b) ? -1 : real(d, a, e, b, g); }

/* Count from the beginning again, in a process that was forked for one trial. */
void failing_reset(void) { atomic_store(&calls, 0); }
long failing_calls(void) { return atomic_load(&calls); }
