/* An FMU for the tests, strict about the order of calls, with misbehaviour on request.
 *
 * KIND 0: integrator, x += h gain u, y = x + offset
 * KIND 1: static gain, y = gain u + offset, at every read
 * KIND 2: sampled gain, y = gain u + offset as of the end of the last step, at every read before
 * BROKEN: fmi2GetVersion says 1.0
 * PYTHON: calls a function of a library that it does not link
 * HANGING: no step ends
 * ENDS_PROCESS: the library ends the process when it is loaded; 2: when it is instantiated
 * UNINSTANTIABLE: fmi2Instantiate does not return
 *
 * Value references: 0 u, 1 y, 2 gain, 3 offset (Real); 4 misbehaviour, 5 steps, 10 living states of
 * the library, 11 living instances of the library (Integer); 6 enabled, 7 y > 0 (Boolean);
 * 8 label, 12 resource location (String).
 */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#ifndef _WIN32
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#endif
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *Component;
typedef int Status;
enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING };
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, Status);
    void *environment;
} Callbacks;

enum { I, M, C, F, X, T, E };
typedef struct {
    int phase, misbehaviour, steps, enabled, fatal;
    double u, gain, offset, x, latched, time, reached;
    char label[64];
} State;
typedef struct {
    State s;
    Callbacks callbacks; /* a copy, as importers may expect */
    const Callbacks *original;
    char name[64], resources[1024];
} Instance;

static int living_states, living_instances;

/* For good, at full load. A file in the folder HANGS_IN, with the number of the process as its name, is locked. */
static void hang(void) {
#ifndef _WIN32
    const char *folder = getenv("HANGS_IN");
    char before[1024], path[1024];
    if (folder) {
        snprintf(before, sizeof before, "%s/../%ld", folder, (long)getpid());
        snprintf(path, sizeof path, "%s/%ld", folder, (long)getpid());
        if (flock(open(before, O_CREAT | O_WRONLY, 0600), LOCK_EX) == 0) rename(before, path);
    }
#endif
    for (volatile int forever = 1; forever;) {}
}

static Status say(Instance *c, Status status, const char *text) {
    c->callbacks.logger(c->callbacks.environment, c->name, status, "logStatusError", "%s", text);
    if (status == ERROR) c->s.phase = E;
    return status;
}
#define NEED(c, condition) if (!(condition)) return say((Instance *)(c), ERROR, "illegal call: " #condition)
#define PHASE(c) (((Instance *)(c))->s.phase)

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
#ifdef PYTHON
void Py_Initialize(void);
EXPORT void start_python(void) { Py_Initialize(); }
#endif
#ifdef BROKEN
EXPORT const char *fmi2GetVersion(void) { return "1.0"; }
#else
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
#endif
EXPORT Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const names[]) {
    (void)on;
    for (size_t i = 0; i < n; i++)
        if (strcmp(names[i], "logStatusError")) return say(c, ERROR, "unknown category");
    return OK;
}
#if ENDS_PROCESS == 1
__attribute__((constructor)) static void end_process(void) { _Exit(0); }
#endif
static void start(State *s) {
    memset(s, 0, sizeof *s);
    s->gain = 1; s->enabled = 1; s->phase = I;
    strcpy(s->label, "none");
}
EXPORT Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                                 const Callbacks *callbacks, int visible, int logging) {
    (void)visible; (void)logging;
#if ENDS_PROCESS == 2
    _Exit(0);
#endif
#ifdef UNINSTANTIABLE
    hang();
#endif
    if (type != 1 || strcmp(guid, "{test-guid}")) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatusError",
                          "the GUID is %s", guid);
        return NULL;
    }
    Instance *c = callbacks->allocate(1, sizeof *c);
    start(&c->s);
    c->callbacks = *callbacks;
    c->original = callbacks;
    strncpy(c->name, name, sizeof c->name - 1);
    strncpy(c->resources, resources, sizeof c->resources - 1);
    living_instances++;
    return c;
}
EXPORT void fmi2FreeInstance(Component component) {
    Instance *c = component;
    if (!c) return;
    living_instances--;
    /* The struct that was passed has to be at its place still. */
    c->original->release(c);
}
EXPORT Status fmi2SetupExperiment(Component c, int td, double tol, double t0, int sd, double t1) {
    (void)td; (void)tol; (void)sd; (void)t1;
    NEED(c, PHASE(c) == I);
    ((Instance *)c)->s.time = t0;
    return OK;
}
EXPORT Status fmi2EnterInitializationMode(Component c) { NEED(c, PHASE(c) == I); PHASE(c) = M; return OK; }
EXPORT Status fmi2ExitInitializationMode(Component c) { NEED(c, PHASE(c) == M); PHASE(c) = C; return OK; }
EXPORT Status fmi2Terminate(Component c) { NEED(c, PHASE(c) == C || PHASE(c) == F); PHASE(c) = T; return OK; }
EXPORT Status fmi2Reset(Component c) { start(&((Instance *)c)->s); return OK; }

static double y(const State *s) {
#if KIND == 0
    return s->x + s->offset;
#elif KIND == 1
    return s->gain * s->u + s->offset;
#else
    return s->steps ? s->latched : s->gain * s->u + s->offset;
#endif
}
EXPORT Status fmi2GetReal(Component component, const unsigned *vr, size_t n, double *value) {
    Instance *c = component;
    NEED(c, c->s.phase != I);
    for (size_t i = 0; i < n; i++) switch (vr[i]) {
        case 0: value[i] = c->s.u; break;
        case 1: value[i] = c->s.misbehaviour == 7 && c->s.steps ? 0.0 / 0.0 : y(&c->s); break;
        case 2: value[i] = c->s.gain; break;
        case 3: value[i] = c->s.offset; break;
        default: return say(c, ERROR, "no such Real");
    }
    return OK;
}
EXPORT Status fmi2SetReal(Component component, const unsigned *vr, size_t n, const double *value) {
    Instance *c = component;
    for (size_t i = 0; i < n; i++) switch (vr[i]) {
        case 0: NEED(c, c->s.phase == M || c->s.phase == C); c->s.u = value[i]; break;
        case 2: NEED(c, c->s.phase <= C); c->s.gain = value[i]; break;
        case 3: NEED(c, c->s.phase <= M); c->s.offset = value[i]; break;
        default: return say(c, ERROR, "no such Real");
    }
    return OK;
}
EXPORT Status fmi2GetInteger(Component component, const unsigned *vr, size_t n, int *value) {
    Instance *c = component;
    NEED(c, c->s.phase != I);
    for (size_t i = 0; i < n; i++) switch (vr[i]) {
        case 4: value[i] = c->s.misbehaviour; break;
        case 5: value[i] = c->s.steps; break;
        case 10: value[i] = living_states; break;
        case 11: value[i] = living_instances; break;
        default: return say(c, ERROR, "no such Integer");
    }
    return OK;
}
EXPORT Status fmi2SetInteger(Component component, const unsigned *vr, size_t n, const int *value) {
    Instance *c = component;
    for (size_t i = 0; i < n; i++) {
        NEED(c, vr[i] == 4);
        c->s.misbehaviour = value[i];
    }
    return OK;
}
EXPORT Status fmi2GetBoolean(Component component, const unsigned *vr, size_t n, int *value) {
    Instance *c = component;
    NEED(c, c->s.phase != I);
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == 6 ? c->s.enabled : y(&c->s) > 0;
    return OK;
}
EXPORT Status fmi2SetBoolean(Component component, const unsigned *vr, size_t n, const int *value) {
    Instance *c = component;
    for (size_t i = 0; i < n; i++) {
        NEED(c, vr[i] == 6 && (value[i] == 0 || value[i] == 1));
        c->s.enabled = value[i];
    }
    return OK;
}
EXPORT Status fmi2GetString(Component component, const unsigned *vr, size_t n, const char **value) {
    Instance *c = component;
    NEED(c, c->s.phase != I);
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == 8 ? c->s.label : c->resources;
    return OK;
}
EXPORT Status fmi2SetString(Component component, const unsigned *vr, size_t n, const char *const *value) {
    Instance *c = component;
    for (size_t i = 0; i < n; i++) {
        NEED(c, vr[i] == 8 && strlen(value[i]) < sizeof c->s.label);
        strcpy(c->s.label, value[i]);
    }
    return OK;
}
EXPORT Status fmi2GetFMUstate(Component component, void **state) {
    Instance *c = component;
    if (!*state) { *state = c->callbacks.allocate(1, sizeof(State)); living_states++; }
    memcpy(*state, &c->s, sizeof(State));
    return OK;
}
EXPORT Status fmi2SetFMUstate(Component c, void *state) {
    memcpy(&((Instance *)c)->s, state, sizeof(State));
    return OK;
}
EXPORT Status fmi2FreeFMUstate(Component c, void **state) {
    if (!*state) return OK;
    ((Instance *)c)->callbacks.release(*state);
    *state = NULL;
    living_states--;
    return OK;
}
EXPORT Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size) {
    (void)c; (void)state; *size = sizeof(State); return OK;
}
EXPORT Status fmi2SerializeFMUstate(Component c, void *state, char bytes[], size_t size) {
    NEED(c, size == sizeof(State));
    memcpy(bytes, state, size);
    return OK;
}
EXPORT Status fmi2DeSerializeFMUstate(Component c, const char bytes[], size_t size, void **state) {
    NEED(c, size == sizeof(State));
    *state = ((Instance *)c)->callbacks.allocate(1, sizeof(State));
    living_states++;
    memcpy(*state, bytes, size);
    return OK;
}
EXPORT Status fmi2GetDirectionalDerivative(Component c, const unsigned *z, size_t nz, const unsigned *v,
                                           size_t nv, const double *dv, double *dz) {
    NEED(c, nz == 1 && nv == 1 && z[0] == 1 && v[0] == 0);
    dz[0] = KIND == 0 ? 0 : ((Instance *)c)->s.gain * dv[0];
    return OK;
}
EXPORT Status fmi2SetRealInputDerivatives(Component c, const unsigned *vr, size_t n, const int *order, const double *v) {
    (void)vr; (void)v;
    NEED(c, n == 1 && order[0] == 1);
    return OK;
}
EXPORT Status fmi2GetRealOutputDerivatives(Component c, const unsigned *vr, size_t n, const int *order, double *v) {
    (void)vr;
    NEED(c, n == 1 && order[0] == 1);
    v[0] = ((Instance *)c)->s.u;
    return OK;
}
EXPORT Status fmi2DoStep(Component component, double t, double h, int no_set_prior) {
    (void)no_set_prior;
    Instance *c = component;
    State *s = &c->s;
    NEED(c, s->phase == C && !s->fatal);
#ifdef HANGING
    hang();
#endif
    NEED(c, h > 0 && t - s->time < 1e-3 * h && s->time - t < 1e-3 * h);
    switch (s->misbehaviour) {
        case 1: say(c, DISCARD, "the step is too long"); s->phase = F; return DISCARD;
        case 2: return say(c, ERROR, "the model is broken: 100 %d");
        case 3: say(c, FATAL, "out of order"); s->fatal = 1; return FATAL;
        case 4: return PENDING;
        case 5: return 42;
        case 6: say(c, WARNING, "far from the operating point"); break;
        case 9: abort();
        /* Hangs, if not for ever. */
        case 10: for (time_t end = time(NULL) + 5; s->steps == 0 && time(NULL) < end;) {} break;
        /* Ends the simulation within the step from t = 0.5 on. */
        case 12:
            if (t > 0.45) {
                s->reached = t + 0.25 * h;
                s->x += 0.25 * h * s->gain * s->u;
                s->phase = F;
                return DISCARD;
            }
            break;
        /* Breaks at t = 0.5. */
        case 13: if (t > 0.45) return say(c, ERROR, "broken at last"); break;
        /* Ends the process as if all were well. */
        case 14: _Exit(0);
        /* Crashes at t = 0.5. */
        case 16: if (t > 0.45) abort(); break;
        /* Other pointers than the environment that was passed. */
        case 11:
            c->callbacks.logger((void *)1, c->name, WARNING, "logStatusError", "%s", "a number");
            c->callbacks.logger(c, c->name, WARNING, "logStatusError", "%s", "the component");
            break;
        case 15: hang(); break;
        case 8: for (int i = 0; i < 3000; i++) say(c, OK, "chatter"); break;
    }
    s->x += h * s->gain * s->u * s->enabled;
    s->latched = s->gain * s->u + s->offset;
    s->time = t + h;
    s->steps++;
    return s->misbehaviour == 6 ? WARNING : OK;
}
EXPORT Status fmi2CancelStep(Component c) { PHASE(c) = X; return OK; }
EXPORT Status fmi2GetStatus(Component c, int s, Status *v) { (void)c; (void)s; (void)v; return DISCARD; }
EXPORT Status fmi2GetRealStatus(Component c, int s, double *v) {
    if (s != 2 || PHASE(c) != F) return DISCARD;
    *v = ((Instance *)c)->s.reached;
    return OK;
}
EXPORT Status fmi2GetIntegerStatus(Component c, int s, int *v) { (void)c; (void)s; (void)v; return DISCARD; }
EXPORT Status fmi2GetBooleanStatus(Component c, int s, int *v) {
    if (s != 3 || PHASE(c) != F) return DISCARD;
    *v = ((Instance *)c)->s.reached > 0;
    return OK;
}
#ifndef INCOMPLETE
EXPORT Status fmi2GetStringStatus(Component c, int s, const char **v) { (void)c; (void)s; (void)v; return DISCARD; }
#endif
