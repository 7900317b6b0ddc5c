/* A case of gearplay as a model that is stepped: what fmi2.c and fmi3.c have in common. */
#ifndef MODEL_H
#define MODEL_H
#include <stddef.h>
#include <stdint.h>

#include "data.h" /* written for each case: the case's memory, names and sizes */

#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

enum phase { INSTANTIATED = 1, INITIALISING = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16 };
enum { MESSAGE = 512 };

typedef struct {
    uint64_t *spare; /* an image for trials */
    uint64_t *image; /* memory of the system, the run and its inputs: a copy of the case's, with addresses of its own */
    double inputs[INPUTS + 1];
    double tunes[TUNES + 1];
    double start; /* time [s] of the master at which the motion began */
    int phase;
    int begun; /* whether the image holds the motion of these inputs and parameters */
    char message[MESSAGE]; /* the sentence of the last error */
} Model;

/* A state that is kept: the image with relative addresses, and the numbers beside it. */
typedef struct {
    uint64_t model, size, sum; /* digest of the model, bytes of the whole, checksum of what follows */
    double inputs[INPUTS + 1];
    double tunes[TUNES + 1];
    double start;
    int64_t phase, begun;
    uint64_t image[IMAGE_WORDS];
} State;

/* Functions that return an int return 0, or 1 with a sentence in `message`. */
Model *model_new(void);
void model_free(Model *model);
void model_reset(Model *model);
int model_may(Model *model, const char *function, int phases);
int model_get(Model *model, uint32_t reference, double *value);
int model_set(Model *model, uint32_t reference, double value);
int model_begin(Model *model);
int model_derive(Model *model, const uint32_t unknowns[], size_t n, const uint32_t knowns[], size_t m, const double seed[],
                 double found[]);
int model_step(Model *model, double time, double length);
double model_time(const Model *model);
void model_save(const Model *model, State *state);
int model_restore(Model *model, const State *state);
int model_is_state(Model *model, const void *bytes, size_t size);
int model_fail(Model *model, const char *format, ...);
#endif
