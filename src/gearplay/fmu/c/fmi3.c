/* FMI 3.0 for co-simulation: every function of the standard's header; those of other kinds of simulation refuse. */
#include "fmi3.h"

#include <stdlib.h>
#include <string.h>

#include "model.h"

typedef struct {
    Model *model;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Instance;

static void log_error(Instance *it) {
    if (it->log) it->log(it->environment, fmi3Error, "logStatusError", it->model->message);
}

#define FMI(name) fmi3##name
#define COMPONENT fmi3Instance
#define FMU_STATE fmi3FMUState
#define STATE(verb) fmi3##verb##FMUState
#define SERIALIZED_SIZE fmi3SerializedFMUStateSize
#define SERIALIZE fmi3SerializeFMUState
#define DESERIALIZE fmi3DeserializeFMUState
#include "common.h"

EXPORTED const char *fmi3GetVersion(void) { return fmi3Version; }

static fmi3Instance nothing(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, const char *words) {
    if (log) log(environment, fmi3Error, "logStatusError", words);
    return NULL;
}

EXPORTED fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logs, fmi3Boolean events,
    fmi3Boolean early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logs, (void)early, (void)required, (void)n, (void)update;
    if (events) return nothing(environment, log, "fmi3InstantiateCoSimulation: this FMU has no event mode.");
    if (!token || strcmp(token, MODEL_TOKEN) != 0)
        return nothing(environment, log, "fmi3InstantiateCoSimulation: the token must be that of this binary, " MODEL_TOKEN ".");
    Instance *it = calloc(1, sizeof(Instance));
    Model *model = model_new();
    if (!it || !model) {
        free(it), model_free(model);
        return nothing(environment, log, "fmi3InstantiateCoSimulation: there is too little memory.");
    }
    it->model = model, it->environment = environment, it->log = log;
    return it;
}

EXPORTED fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                   fmi3Boolean logs, fmi3InstanceEnvironment environment,
                                                   fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logs;
    return nothing(environment, log, "fmi3InstantiateModelExchange: this FMU is for co-simulation.");
}

EXPORTED fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                        fmi3Boolean visible, fmi3Boolean logs,
                                                        fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                        fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                                        fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logs, (void)update, (void)lock, (void)unlock;
    return nothing(environment, log, "fmi3InstantiateScheduledExecution: this FMU is for co-simulation.");
}

EXPORTED void fmi3FreeInstance(fmi3Instance c) {
    Instance *it = c;
    if (!it) return;
    model_free(it->model);
    free(it);
}

EXPORTED fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance, fmi3Float64 start,
                                                fmi3Boolean ends, fmi3Float64 stop) {
    LET("fmi3EnterInitializationMode", INSTANTIATED);
    (void)defined, (void)tolerance, (void)ends, (void)stop; /* the tolerance is the case's */
    if (starts_at(it->model, start)) return status(it, 1);
    it->model->phase = INITIALISING;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t m) {
    LET("fmi3GetFloat64", LIVE | TERMINATED);
    if (n != m) return status(it, model_fail(it->model, "fmi3GetFloat64: there must be as many values as variables."));
    for (size_t k = 0; k < n; k++)
        if (model_get(it->model, vr[k], &values[k])) return status(it, 1);
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                                   size_t m) {
    LET("fmi3SetFloat64", LIVE);
    if (n != m) return status(it, model_fail(it->model, "fmi3SetFloat64: there must be as many values as variables."));
    for (size_t k = 0; k < n; k++)
        if (model_set(it->model, vr[k], values[k])) return status(it, 1);
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n,
                                                 const fmi3ValueReference knowns[], size_t m, const fmi3Float64 seed[],
                                                 size_t seeds, fmi3Float64 sensitivity[], size_t size) {
    LET("fmi3GetDirectionalDerivative", INITIALISING | STEPPING);
    if (seeds != m || size != n)
        return status(it, model_fail(it->model, "fmi3GetDirectionalDerivative: there must be as many values as variables."));
    return status(it, model_derive(it->model, unknowns, n, knowns, m, seed, sensitivity));
}

/* Variables of these types: there are none. */
#define NONE(type)                                                                                                       \
    EXPORTED fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##type values[], size_t m) { \
        (void)vr, (void)values, (void)m;                                                                                 \
        return n == 0 && c ? fmi3OK : refused(c, "fmi3Get" #type);                                                       \
    }                                                                                                                    \
    EXPORTED fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##type values[], \
                                      size_t m) {                                                                        \
        (void)vr, (void)values, (void)m;                                                                                 \
        return n == 0 && c ? fmi3OK : refused(c, "fmi3Set" #type);                                                       \
    }
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(Int32)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
NONE(Boolean)
NONE(String)

EXPORTED fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary values[],
                                  size_t m) {
    (void)vr, (void)sizes, (void)values, (void)m;
    return n == 0 && c ? fmi3OK : refused(c, "fmi3GetBinary");
}

EXPORTED fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                                  const fmi3Binary values[], size_t m) {
    (void)vr, (void)sizes, (void)values, (void)m;
    return n == 0 && c ? fmi3OK : refused(c, "fmi3SetBinary");
}

EXPORTED fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]) {
    (void)vr, (void)values;
    return n == 0 && c ? fmi3OK : refused(c, "fmi3GetClock");
}

EXPORTED fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]) {
    (void)vr, (void)values;
    return n == 0 && c ? fmi3OK : refused(c, "fmi3SetClock");
}

EXPORTED fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_way_back, fmi3Boolean *event,
                               fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached) {
    LET("fmi3DoStep", STEPPING);
    (void)no_way_back;
    int failed = model_step(it->model, time, length);
    if (event) *event = false;
    if (ends) *ends = false;
    if (early) *early = false;
    if (reached) *reached = model_time(it->model);
    return status(it, failed);
}

REFUSES(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
REFUSES(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t of[], fmi3ValueReference on[], size_t at[],
        fmi3DependencyKind kinds[], size_t n)
REFUSES(fmi3GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t n, const fmi3ValueReference knowns[], size_t m,
        const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[], size_t size)
REFUSES(fmi3EnterConfigurationMode)
REFUSES(fmi3ExitConfigurationMode)
REFUSES(fmi3EnterEventMode)
REFUSES(fmi3EnterStepMode)
REFUSES(fmi3EnterContinuousTimeMode)
REFUSES(fmi3GetIntervalDecimal, const fmi3ValueReference vr[], size_t n, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
REFUSES(fmi3GetIntervalFraction, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[])
REFUSES(fmi3GetShiftDecimal, const fmi3ValueReference vr[], size_t n, fmi3Float64 shifts[])
REFUSES(fmi3GetShiftFraction, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSES(fmi3SetIntervalDecimal, const fmi3ValueReference vr[], size_t n, const fmi3Float64 intervals[])
REFUSES(fmi3SetIntervalFraction, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[],
        const fmi3UInt64 resolutions[])
REFUSES(fmi3SetShiftDecimal, const fmi3ValueReference vr[], size_t n, const fmi3Float64 shifts[])
REFUSES(fmi3SetShiftFraction, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSES(fmi3EvaluateDiscreteStates)
REFUSES(fmi3UpdateDiscreteStates, fmi3Boolean *needed, fmi3Boolean *ends, fmi3Boolean *nominals, fmi3Boolean *values,
        fmi3Boolean *defined, fmi3Float64 *next)
REFUSES(fmi3CompletedIntegratorStep, fmi3Boolean no_way_back, fmi3Boolean *event, fmi3Boolean *ends)
REFUSES(fmi3SetTime, fmi3Float64 time)
REFUSES(fmi3SetContinuousStates, const fmi3Float64 x[], size_t n)
REFUSES(fmi3GetContinuousStateDerivatives, fmi3Float64 dx[], size_t n)
REFUSES(fmi3GetEventIndicators, fmi3Float64 g[], size_t n)
REFUSES(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
REFUSES(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
REFUSES(fmi3GetNumberOfEventIndicators, size_t *n)
REFUSES(fmi3GetNumberOfContinuousStates, size_t *n)
REFUSES(fmi3GetOutputDerivatives, const fmi3ValueReference vr[], size_t n, const fmi3Int32 orders[], fmi3Float64 values[], size_t m)
REFUSES(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
