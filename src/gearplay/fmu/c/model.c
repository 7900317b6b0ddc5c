/* A case of gearplay as a model that is stepped. Nothing is allocated between `model_new` and `model_free`. */
#include "model.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DONE = 0, PAUSED = 1, STEPS_AT_ONCE = 100000 };
enum { LINEAR, OF_INVERSE, INVERSE }; /* rules of words, see fmu/tuning.py */

int model_fail(Model *model, const char *format, ...) {
    va_list words;
    va_start(words, format);
    vsnprintf(model->message, MESSAGE, format, words);
    va_end(words);
    return 1;
}

static const gearplay_System *system_of(const Model *model) {
    return (const gearplay_System *)((const char *)model->image + SYSTEM_PLACE);
}

static const gearplay_Run *run_of(const Model *model) {
    return (const gearplay_Run *)((const char *)model->image + RUN_PLACE);
}

static const gearplay_Held *held_of(const Model *model) {
    return (const gearplay_Held *)((const char *)model->image + HELD_PLACE);
}

/* Copy an image, with addresses counted from `base`, or relative ones where it is NULL. */
static void copy_image(uint64_t *image, const uint64_t *source, const uint64_t *base) {
    memcpy(image, source, sizeof(uint64_t) * IMAGE_WORDS);
    for (size_t n = 0; n < RELOCATIONS; n++) image[relocations[n]] = case_image[relocations[n]] + (uint64_t)(uintptr_t)base;
}

Model *model_new(void) {
    Model *model = calloc(1, sizeof(Model));
    if (!model) return NULL;
    model->image = malloc(sizeof(uint64_t) * IMAGE_WORDS);
    model->spare = malloc(sizeof(uint64_t) * IMAGE_WORDS);
    if (!model->image || !model->spare) {
        model_free(model);
        return NULL;
    }
    model_reset(model);
    return model;
}

void model_free(Model *model) {
    if (!model) return;
    free(model->image);
    free(model->spare);
    free(model);
}

void model_reset(Model *model) {
    copy_image(model->image, case_image, model->image);
    for (size_t k = 0; k < INPUTS; k++) model->inputs[k] = input_starts[k];
    for (size_t k = 0; k < TUNES; k++) model->tunes[k] = tunes[k].start;
    model->start = 0.0;
    model->begun = 0;
    model->phase = INSTANTIATED;
    model->message[0] = 0;
}

int model_may(Model *model, const char *function, int phases) {
    if (model->phase & phases) return 0;
    const char *when = model->phase == FAILED       ? "after an error, where only reset and free are"
                       : model->phase == TERMINATED ? "after the end"
                       : model->phase == STEPPING   ? "while it is stepped"
                                                    : "before it is initialised";
    return model_fail(model, "%s: must not be called %s.", function, when);
}

static int status_of(Model *model, int32_t fault, int64_t status) {
    if (fault == 0 && status == DONE) return 0;
    const char *words = "An index was beyond its array.";
    for (size_t n = 0; fault == 0 && n < sizeof statuses / sizeof statuses[0]; n++)
        if (statuses[n].code == status) words = statuses[n].words;
    double reached = run_of(model)->clock[CLOCK_T];
    model->phase = FAILED;
    return model_fail(model, "%s Stopped at t = %.9g s.", words, model->start + reached);
}

static int change_inputs(Model *model, const double inputs[]) {
    int64_t status = PAUSED;
    void *fault = NULL;
    const gearplay_Held *held = held_of(model);
    for (size_t k = 0; k < INPUTS; k++) held->wanted[k] = inputs[k];
    int32_t failed = gearplay_integrate_stepping_change_inputs(&status, &fault, system_of(model), run_of(model), held);
    return failed != 0 || status != DONE ? status_of(model, failed, status) : 0;
}

static int observe(Model *model) {
    int64_t nothing = 0;
    void *fault = NULL;
    return status_of(model, gearplay_integrate_stepping_observe_now((void *)&nothing, &fault, system_of(model), run_of(model)), DONE);
}

static int advance(Model *model, double end) {
    int64_t status = PAUSED;
    int32_t failed = 0;
    void *fault = NULL;
    if (change_inputs(model, model->inputs)) return 1;
    while (failed == 0 && status == PAUSED)
        failed = gearplay_integrate_stepping_advance_to(&status, &fault, system_of(model), run_of(model), end, STEPS_AT_ONCE);
    if (failed != 0 || status != DONE) return status_of(model, failed, status);
    return observe(model);
}

int model_begin(Model *model) {
    if (model->begun) return 0;
    copy_image(model->image, case_image, model->image);
    for (size_t n = 0; n < sizeof words / sizeof words[0]; n++) {
        const struct word *each = &words[n];
        if (each->tune < 0) break;
        const struct tune *tune = &tunes[each->tune];
        double value = model->tunes[each->tune];
        if (value == tune->start) continue; /* the case's own word, to the last bit */
        double change = each->kind == OF_INVERSE ? 1.0 / value - 1.0 / tune->start : value - tune->start;
        double word = each->value + each->slope * change;
        if (each->kind == INVERSE) word = 1.0 / word;
        memcpy(&model->image[each->place], &word, sizeof word);
    }
    model->begun = 1;
    return advance(model, 0.0);
}

double model_time(const Model *model) { return model->start + (model->begun ? run_of(model)->clock[CLOCK_T] : 0.0); }

int model_step(Model *model, double time, double length) {
    double reached = model_time(model), scale = fabs(reached) > 1.0 ? fabs(reached) : 1.0;
    if (!(length >= 0.0 && length <= 1e6))
        return model_fail(model, "communicationStepSize = %g: must be a time of 0 to 1e6 s.", length);
    if (!(fabs(time - reached) <= 1e-9 * scale))
        return model_fail(model, "currentCommunicationPoint = %.17g: must be %.17g, where the last step ended.", time, reached);
    return advance(model, time - model->start + length);
}

/* Observe the outputs of this point of time with one input changed by a step, in the spare image. */
static int try_inputs(Model *model, size_t known, double step) {
    double inputs[INPUTS + 1];
    uint64_t *image = model->image;
    memcpy(inputs, model->inputs, sizeof inputs);
    inputs[known] += step;
    copy_image(model->spare, image, model->spare);
    model->image = model->spare;
    int phase = model->phase, failed = change_inputs(model, inputs) || observe(model);
    model->image = image;
    model->phase = phase;
    return failed;
}

/* The derivative of outputs by inputs at a communication point, as after a step of length 0: what passes through at once. While no
   control is at its limit and none reaches it, outputs are affine in torques and set-points, and a difference is exact but for
   rounding. */
int model_derive(Model *model, const uint32_t unknowns[], size_t n, const uint32_t knowns[], size_t m, const double seed[],
                 double found[]) {
    for (size_t j = 0; j < n; j++) {
        if (unknowns[j] <= INPUTS || unknowns[j] > INPUTS + OUTPUTS)
            return model_fail(model, "valueReference = %lu: must be that of an output.", (unsigned long)unknowns[j]);
        found[j] = 0.0;
    }
    for (size_t k = 0; k < m; k++)
        if (knowns[k] < 1 || knowns[k] > INPUTS || !isfinite(seed[k]))
            return model_fail(model, "valueReference = %lu: must be that of an input, with a finite seed.", (unsigned long)knowns[k]);
    if (!model->begun && model_begin(model)) return 1;
    for (size_t k = 0; k < m; k++) {
        double size = fabs(model->inputs[knowns[k] - 1]), step = size > 0.1 ? 1e-3 * size : 1e-4;
        for (int side = 1; side >= -1; side -= 2) {
            if (try_inputs(model, knowns[k] - 1, side * step)) return 1;
            const gearplay_Run *tried = (const gearplay_Run *)((const char *)model->spare + RUN_PLACE);
            for (size_t j = 0; j < n; j++) found[j] += side * seed[k] * tried->rows[unknowns[j] - 1 - INPUTS] / (2.0 * step);
        }
    }
    return 0;
}

int model_get(Model *model, uint32_t reference, double *value) {
    if (reference == 0) {
        *value = model_time(model);
    } else if (reference <= INPUTS) {
        *value = model->inputs[reference - 1];
    } else if (reference <= INPUTS + OUTPUTS) {
        if (!model->begun && model_begin(model)) return 1;
        *value = run_of(model)->rows[reference - 1 - INPUTS];
    } else if (reference <= INPUTS + OUTPUTS + TUNES) {
        *value = model->tunes[reference - 1 - INPUTS - OUTPUTS];
    } else {
        return model_fail(model, "valueReference = %lu: must be that of a variable.", (unsigned long)reference);
    }
    return 0;
}

int model_set(Model *model, uint32_t reference, double value) {
    if (!isfinite(value))
        return model_fail(model, "valueReference = %lu: must be given a finite number.", (unsigned long)reference);
    if (reference >= 1 && reference <= INPUTS) {
        model->inputs[reference - 1] = value;
        if (model->phase & (INSTANTIATED | INITIALISING)) model->begun = 0;
        return 0;
    }
    if (reference <= INPUTS + OUTPUTS || reference > INPUTS + OUTPUTS + TUNES)
        return model_fail(model, "valueReference = %lu: must be that of an input or a parameter.", (unsigned long)reference);
    const struct tune *tune = &tunes[reference - 1 - INPUTS - OUTPUTS];
    if (!(model->phase & (INSTANTIATED | INITIALISING)))
        return model_fail(model, "%s: must be set before the end of initialisation.", tune->name);
    if (!(value >= tune->low && value <= tune->high))
        return model_fail(model, "%s = %g: must be from %g to %g.", tune->name, value, tune->low, tune->high);
    model->tunes[reference - 1 - INPUTS - OUTPUTS] = value;
    model->begun = 0;
    return 0;
}

static uint64_t sum_of(const State *state) {
    uint64_t sum = 14695981039346656037u; /* FNV-1a, of words */
    const uint64_t *last = (const uint64_t *)(state + 1);
    for (const uint64_t *word = (const uint64_t *)state + 3; word < last; word++) sum = (sum ^ *word) * 1099511628211u;
    return sum;
}

void model_save(const Model *model, State *state) {
    memset(state, 0, offsetof(State, image));
    state->model = MODEL_DIGEST;
    state->size = sizeof(State);
    memcpy(state->inputs, model->inputs, sizeof model->inputs);
    memcpy(state->tunes, model->tunes, sizeof model->tunes);
    state->start = model->start;
    state->phase = model->phase;
    state->begun = model->begun;
    copy_image(state->image, model->image, NULL);
    state->sum = sum_of(state);
}

int model_restore(Model *model, const State *state) {
    memcpy(model->inputs, state->inputs, sizeof model->inputs);
    memcpy(model->tunes, state->tunes, sizeof model->tunes);
    model->start = state->start;
    model->phase = (int)state->phase;
    model->begun = (int)state->begun;
    copy_image(model->image, state->image, model->image);
    return 0;
}

int model_is_state(Model *model, const void *bytes, size_t size) {
    const State *state = bytes;
    if (size != sizeof(State) || state->model != MODEL_DIGEST || state->size != size || state->sum != sum_of(state))
        return model_fail(model, "The serialised state is damaged, or of another model.");
    return 0;
}
