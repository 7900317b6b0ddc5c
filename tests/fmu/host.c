/* Two instances of an FMU of FMI 2.0 in two threads, states on the way, memory over many steps: host LIBRARY GUID STEPS. */
#include <dlfcn.h>
#include <malloc.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
static int (*setup)(Component, int, double, double, int, double), (*enter)(Component), (*leave)(Component), (*reset)(Component);
static int (*set)(Component, const unsigned *, size_t, const double *), (*get)(Component, const unsigned *, size_t, double *);
static int (*step)(Component, double, double, int);
static int (*keep)(Component, void **), (*restore)(Component, void *), (*drop)(Component, void **);
static int (*size_of)(Component, void *, size_t *), (*serialise)(Component, void *, char *, size_t);
static int (*deserialise)(Component, const char *, size_t, void **);
static void (*release)(Component);
static const char *guid;
static long steps;

static void say(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list words;
    va_start(words, format);
    fprintf(stderr, "%s %s (%d): ", name, category, status);
    vfprintf(stderr, format, words);
    fputc('\n', stderr);
    va_end(words);
    (void)environment;
}

static const Callbacks callbacks = {say, NULL, NULL, NULL, NULL};

static Component begun(const char *name) {
    Component c = instantiate(name, 1, guid, NULL, &callbacks, 0, 0);
    if (!c || setup(c, 0, 0.0, 0.0, 0, 0.0) || enter(c) || leave(c)) exit(5);
    return c;
}

/* Takes steps with a torque that changes; prints what it arrives at. */
static void *run(void *word) {
    double torque, found;
    unsigned input = 1, output = 2;
    Component c = begun(word);
    for (long n = 0; n < steps; n++) {
        torque = 50.0 + n % 3;
        if (set(c, &input, 1, &torque) || step(c, n * 1e-5, 1e-5, 1)) exit(6);
    }
    if (get(c, &output, 1, &found)) exit(7);
    release(c);
    double *kept = malloc(sizeof *kept);
    *kept = found;
    return kept;
}

int main(int count, char **words) {
    void *library = count == 4 ? dlopen(words[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 3;
    guid = words[2], steps = strtol(words[3], NULL, 10);
#define FIND(place, name) if (!(*(void **)&place = dlsym(library, name))) return fprintf(stderr, "%s is missing\n", name), 4
    FIND(instantiate, "fmi2Instantiate");
    FIND(setup, "fmi2SetupExperiment");
    FIND(enter, "fmi2EnterInitializationMode");
    FIND(leave, "fmi2ExitInitializationMode");
    FIND(reset, "fmi2Reset");
    FIND(set, "fmi2SetReal");
    FIND(get, "fmi2GetReal");
    FIND(step, "fmi2DoStep");
    FIND(keep, "fmi2GetFMUstate");
    FIND(restore, "fmi2SetFMUstate");
    FIND(drop, "fmi2FreeFMUstate");
    FIND(size_of, "fmi2SerializedFMUstateSize");
    FIND(serialise, "fmi2SerializeFMUstate");
    FIND(deserialise, "fmi2DeSerializeFMUstate");
    FIND(release, "fmi2FreeInstance");
    double *alone = run("alone");
    pthread_t threads[2];
    void *found[2];
    for (int n = 0; n < 2; n++) pthread_create(&threads[n], NULL, run, n ? "second" : "first");
    for (int n = 0; n < 2; n++) pthread_join(threads[n], &found[n]);
    if (*(double *)found[0] != *alone || *(double *)found[1] != *alone) return 8;

    Component c = begun("kept"), other = begun("other");
    unsigned output = 2;
    double first, second;
    void *state = NULL, *back = NULL;
    for (long n = 0; n < 100; n++) step(c, n * 1e-5, 1e-5, 1);
    if (keep(c, &state)) return 9;
    for (long n = 100; n < 200; n++) step(c, n * 1e-5, 1e-5, 1);
    get(c, &output, 1, &first);
    size_t size = 0;
    if (size_of(c, state, &size)) return 10;
    char *bytes = malloc(size);
    if (serialise(c, state, bytes, size) || deserialise(other, bytes, size, &back)) return 10;
    if (restore(c, state) || restore(other, back)) return 11;
    for (long n = 100; n < 200; n++) step(c, n * 1e-5, 1e-5, 1), step(other, n * 1e-5, 1e-5, 1);
    get(c, &output, 1, &second);
    if (second != first) return 12;
    get(other, &output, 1, &second);
    if (second != first) return 13;
    bytes[size / 2] ^= 1;
    if (deserialise(other, bytes, size, &back) == 0 || deserialise(other, bytes, size - 1, &back) == 0) return 14;
    free(bytes), drop(c, &state), drop(other, &back), release(other);
    if (state || back) return 15;

    if (reset(c) || enter(c) || leave(c)) return 16;
    size_t before = mallinfo2().uordblks;
    for (long n = 0; n < steps; n++)
        if (step(c, n * 1e-5, 1e-5, 1)) return 17;
    printf("%.17g %zd\n", *alone, (ssize_t)(mallinfo2().uordblks - before));
    release(c);
    return 0;
}
