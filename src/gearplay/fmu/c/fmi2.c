/* FMI 2.0 for co-simulation: every function of the standard's header; those of model exchange refuse. */
#include "fmi2.h"

#include <stdlib.h>
#include <string.h>

#include "model.h"

typedef struct {
    Model *model;
    fmi2CallbackFunctions callbacks;
    char *name;
} Instance;

static void say(const fmi2CallbackFunctions *callbacks, const char *name, const char *words) {
    if (callbacks && callbacks->logger)
        callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError", "%s", words);
}

static void log_error(Instance *it) { say(&it->callbacks, it->name, it->model->message); }

#define FMI(name) fmi2##name
#define COMPONENT fmi2Component
#define FMU_STATE fmi2FMUstate
#define STATE(verb) fmi2##verb##FMUstate
#define SERIALIZED_SIZE fmi2SerializedFMUstateSize
#define SERIALIZE fmi2SerializeFMUstate
#define DESERIALIZE fmi2DeSerializeFMUstate
#include "common.h"

EXPORTED const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
EXPORTED const char *fmi2GetVersion(void) { return fmi2Version; }

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logs) {
    (void)resources, (void)visible, (void)logs;
    const char *shown = name ? name : "";
    if (type != fmi2CoSimulation) {
        say(callbacks, shown, "fmi2Instantiate: this FMU is for co-simulation.");
        return NULL;
    }
    if (!guid || strcmp(guid, MODEL_TOKEN) != 0) {
        say(callbacks, shown, "fmi2Instantiate: the GUID must be that of this binary, " MODEL_TOKEN ".");
        return NULL;
    }
    Instance *it = calloc(1, sizeof(Instance));
    Model *model = model_new();
    char *kept = malloc(strlen(shown) + 1);
    if (!it || !model || !kept) {
        free(it), free(kept), model_free(model);
        say(callbacks, shown, "fmi2Instantiate: there is too little memory.");
        return NULL;
    }
    it->model = model;
    it->name = strcpy(kept, shown);
    if (callbacks) it->callbacks = *callbacks;
    return it;
}

EXPORTED void fmi2FreeInstance(fmi2Component c) {
    Instance *it = c;
    if (!it) return;
    model_free(it->model);
    free(it->name);
    free(it);
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                                        fmi2Boolean ends, fmi2Real stop) {
    LET("fmi2SetupExperiment", INSTANTIATED);
    (void)defined, (void)tolerance, (void)ends, (void)stop; /* the tolerance is the case's */
    return status(it, starts_at(it->model, start));
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    LET("fmi2EnterInitializationMode", INSTANTIATED);
    it->model->phase = INITIALISING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    LET("fmi2GetReal", LIVE | TERMINATED);
    for (size_t k = 0; k < n; k++)
        if (model_get(it->model, vr[k], &value[k])) return status(it, 1);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    LET("fmi2SetReal", LIVE);
    for (size_t k = 0; k < n; k++)
        if (model_set(it->model, vr[k], value[k])) return status(it, 1);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n,
                                                 const fmi2ValueReference known[], size_t m, const fmi2Real seed[],
                                                 fmi2Real sensitivity[]) {
    LET("fmi2GetDirectionalDerivative", INITIALISING | STEPPING);
    return status(it, model_derive(it->model, unknown, n, known, m, seed, sensitivity));
}

/* Variables of these types: there are none. */
#define NONE(name, type)                                                                                    \
    EXPORTED fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
        (void)vr, (void)value;                                                                              \
        return n == 0 && c ? fmi2OK : refused(c, "fmi2Get" #name);                                          \
    }                                                                                                       \
    EXPORTED fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) { \
        (void)vr, (void)value;                                                                              \
        return n == 0 && c ? fmi2OK : refused(c, "fmi2Set" #name);                                          \
    }
NONE(Integer, fmi2Integer)
NONE(Boolean, fmi2Boolean)
NONE(String, fmi2String)

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean no_way_back) {
    LET("fmi2DoStep", STEPPING);
    (void)no_way_back;
    return status(it, model_step(it->model, time, length));
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component c) { return refused(c, "fmi2CancelStep"); }

EXPORTED fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return c ? fmi2Discard : fmi2Error; /* no step is pending */
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    Instance *it = c;
    if (!it) return fmi2Error;
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = model_time(it->model);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind, (void)value;
    return c ? fmi2Discard : fmi2Error;
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (!c) return fmi2Error;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind, (void)value;
    return c ? fmi2Discard : fmi2Error;
}

REFUSES(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real value[])
REFUSES(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real value[])
REFUSES(fmi2EnterEventMode)
REFUSES(fmi2NewDiscreteStates, fmi2EventInfo *info)
REFUSES(fmi2EnterContinuousTimeMode)
REFUSES(fmi2CompletedIntegratorStep, fmi2Boolean no_way_back, fmi2Boolean *event, fmi2Boolean *end)
REFUSES(fmi2SetTime, fmi2Real time)
REFUSES(fmi2SetContinuousStates, const fmi2Real x[], size_t n)
REFUSES(fmi2GetDerivatives, fmi2Real dx[], size_t n)
REFUSES(fmi2GetEventIndicators, fmi2Real g[], size_t n)
REFUSES(fmi2GetContinuousStates, fmi2Real x[], size_t n)
REFUSES(fmi2GetNominalsOfContinuousStates, fmi2Real nominal[], size_t n)
