/* A program that steps an FMU of FMI 3.0:
 *
 *     host LIBRARY TOKEN STEPS LENGTH [REFERENCE=VALUE ...] [REFERENCE ...]
 *
 * sets inputs and parameters by their value references, takes STEPS steps of LENGTH [s], and prints the variables named after them.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define OPEN(file) ((void *)LoadLibraryA(file))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(file) dlopen(file, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#endif

typedef void *Instance;

static void say(void *environment, int status, const char *category, const char *message) {
    (void)environment;
    fprintf(stderr, "%s (%d): %s\n", category, status, message);
}

static void *found(void *library, const char *name) {
    void *function = FIND(library, name);
    if (!function) fprintf(stderr, "%s is missing\n", name), exit(3);
    return function;
}

static void check(int status, const char *name) {
    if (status != 0) fprintf(stderr, "%s: status %d\n", name, status), exit(4);
}

int main(int count, char **words) {
    if (count < 5) return 2;
    void *library = OPEN(words[1]);
    if (!library) return fprintf(stderr, "cannot open %s\n", words[1]), 3;
    Instance (*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t, void *,
                            void (*)(void *, int, const char *, const char *), void *) =
        found(library, "fmi3InstantiateCoSimulation");
    int (*enter)(Instance, bool, double, double, bool, double) = found(library, "fmi3EnterInitializationMode");
    int (*leave)(Instance) = found(library, "fmi3ExitInitializationMode");
    int (*set)(Instance, const uint32_t *, size_t, const double *, size_t) = found(library, "fmi3SetFloat64");
    int (*get)(Instance, const uint32_t *, size_t, double *, size_t) = found(library, "fmi3GetFloat64");
    int (*step)(Instance, double, double, bool, bool *, bool *, bool *, double *) = found(library, "fmi3DoStep");
    int (*terminate)(Instance) = found(library, "fmi3Terminate");
    void (*release)(Instance) = found(library, "fmi3FreeInstance");

    Instance drive = instantiate("drive", words[2], NULL, false, false, false, false, NULL, 0, NULL, say, NULL);
    if (!drive) return 5;
    check(enter(drive, false, 0.0, 0.0, false, 0.0), "fmi3EnterInitializationMode");
    for (int n = 5; n < count; n++) {
        char *value = strchr(words[n], '=');
        uint32_t reference = (uint32_t)strtoul(words[n], NULL, 10);
        double number = value ? strtod(value + 1, NULL) : 0.0;
        if (value) check(set(drive, &reference, 1, &number, 1), "fmi3SetFloat64");
    }
    check(leave(drive), "fmi3ExitInitializationMode");
    double length = strtod(words[4], NULL), reached = 0.0;
    long steps = strtol(words[3], NULL, 10);
    bool event, ends, early;
    for (long n = 0; n < steps; n++) check(step(drive, n * length, length, true, &event, &ends, &early, &reached), "fmi3DoStep");
    for (int n = 5; n < count; n++) {
        uint32_t reference = (uint32_t)strtoul(words[n], NULL, 10);
        double number = 0.0;
        if (strchr(words[n], '=')) continue;
        check(get(drive, &reference, 1, &number, 1), "fmi3GetFloat64");
        printf("%.17g\n", number);
    }
    check(terminate(drive), "fmi3Terminate");
    release(drive);
    return 0;
}
