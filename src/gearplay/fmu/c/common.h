/* What fmi2.c and fmi3.c have in common. Before it a version defines
   FMI(name), a function or type of its own; COMPONENT, its instances; FMU_STATE and STATE(verb), its states and their functions;
   SERIALIZED_SIZE, SERIALIZE, DESERIALIZE; Instance, with `model`; and log_error(it). */
#define WORDS_OF(name) #name
#define NAME_OF(name) WORDS_OF(name)

enum { ANY = INSTANTIATED | INITIALISING | STEPPING | TERMINATED | FAILED, LIVE = INSTANTIATED | INITIALISING | STEPPING };

static FMI(Status) status(Instance *it, int failed) {
    if (!failed) return FMI(OK);
    log_error(it);
    return FMI(Error);
}

static FMI(Status) refused(COMPONENT c, const char *function) {
    Instance *it = c;
    return it ? status(it, model_fail(it->model, "%s: is not a function of this FMU.", function)) : FMI(Error);
}

#define LET(function, phases)                                                    \
    Instance *it = c;                                                            \
    if (!it) return FMI(Error);                                                  \
    if (model_may(it->model, function, phases)) return status(it, 1)

#define REFUSES(function, ...) \
    EXPORTED FMI(Status) function(COMPONENT c, ##__VA_ARGS__) { return refused(c, #function); }

static int starts_at(Model *model, double start) {
    if (!(start >= -1e9 && start <= 1e9)) return model_fail(model, "startTime = %g: must be within 1e9 s.", start);
    model->start = start;
    return 0;
}

EXPORTED FMI(Status) FMI(SetDebugLogging)(COMPONENT c, FMI(Boolean) on, size_t n, const FMI(String) categories[]) {
    (void)on, (void)n, (void)categories; /* errors are always logged, and nothing else is */
    return c ? FMI(OK) : FMI(Error);
}

EXPORTED FMI(Status) FMI(ExitInitializationMode)(COMPONENT c) {
    LET(NAME_OF(FMI(ExitInitializationMode)), INITIALISING);
    if (model_begin(it->model)) return status(it, 1);
    it->model->phase = STEPPING;
    return FMI(OK);
}

EXPORTED FMI(Status) FMI(Terminate)(COMPONENT c) {
    LET(NAME_OF(FMI(Terminate)), STEPPING);
    it->model->phase = TERMINATED;
    return FMI(OK);
}

EXPORTED FMI(Status) FMI(Reset)(COMPONENT c) {
    LET(NAME_OF(FMI(Reset)), ANY);
    model_reset(it->model);
    return FMI(OK);
}

EXPORTED FMI(Status) STATE(Get)(COMPONENT c, FMU_STATE *state) {
    LET(NAME_OF(STATE(Get)), ANY);
    if (!state) return status(it, model_fail(it->model, "%s: needs an address.", NAME_OF(STATE(Get))));
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return status(it, model_fail(it->model, "%s: there is too little memory.", NAME_OF(STATE(Get))));
    model_save(it->model, *state);
    return FMI(OK);
}

EXPORTED FMI(Status) STATE(Set)(COMPONENT c, FMU_STATE state) {
    LET(NAME_OF(STATE(Set)), ANY);
    if (!state) return status(it, model_fail(it->model, "%s: needs a state.", NAME_OF(STATE(Set))));
    return status(it, model_restore(it->model, state));
}

EXPORTED FMI(Status) STATE(Free)(COMPONENT c, FMU_STATE *state) {
    LET(NAME_OF(STATE(Free)), ANY);
    if (state) free(*state), *state = NULL;
    return FMI(OK);
}

EXPORTED FMI(Status) SERIALIZED_SIZE(COMPONENT c, FMU_STATE state, size_t *size) {
    LET(NAME_OF(SERIALIZED_SIZE), ANY);
    (void)state;
    *size = sizeof(State);
    return FMI(OK);
}

EXPORTED FMI(Status) SERIALIZE(COMPONENT c, FMU_STATE state, FMI(Byte) bytes[], size_t size) {
    LET(NAME_OF(SERIALIZE), ANY);
    if (!state || size < sizeof(State)) return status(it, model_fail(it->model, "%s: too little room.", NAME_OF(SERIALIZE)));
    memcpy(bytes, state, sizeof(State));
    return FMI(OK);
}

EXPORTED FMI(Status) DESERIALIZE(COMPONENT c, const FMI(Byte) bytes[], size_t size, FMU_STATE *state) {
    LET(NAME_OF(DESERIALIZE), ANY);
    State *made = malloc(sizeof(State));
    if (!made) return status(it, model_fail(it->model, "%s: there is too little memory.", NAME_OF(DESERIALIZE)));
    if (size == sizeof(State)) memcpy(made, bytes, size);
    if (model_is_state(it->model, made, size)) {
        free(made);
        return status(it, 1);
    }
    free(*state);
    *state = made;
    return FMI(OK);
}
