/* Times calls of FMUs and bare libraries, in rounds in which each has its turn.
 *
 *   timing ROUNDS < SUBJECTS > NANOSECONDS
 *
 * A line of SUBJECTS has its fields apart by a tab: what is called, LIBRARY, GUID, URI, STEP,
 * COUNT, the value reference of a Real, the smallest and the largest value that it is given, and
 * the Reals set in initialization mode, REF=VALUE apart by commas: none where the field is empty.
 * What is called is
 *
 *   bare     the function named in the field GUID, with the signature of fmi2DoStep
 *   empty    fmi2GetVersion, of which only the call costs anything
 *   step     fmi2DoStep
 *   get      fmi2GetReal of one variable
 *   set      fmi2SetReal of one variable
 *   setstep  fmi2SetReal with another value each time, and fmi2DoStep
 *
 * A line of NANOSECONDS has, for one round, the nanoseconds a call of each subject. */
#define _POSIX_C_SOURCE 199309L
#include "fmi2Functions.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 128 };

struct subject {
    char kind[16];
    double step, low, high;
    long count, done;
    fmi2ValueReference reference;
    fmi2Component component;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2SetRealTYPE *set_real;
    fmi2GetVersionTYPE *get_version;
};

static struct subject subjects[MOST];

static void fail(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static void find(void *library, const char *name, void *function) {
    void *address = dlsym(library, name);
    if (!address) fail(name);
    memcpy(function, &address, sizeof address);
}

static void start(struct subject *s, void *library, const char *guid, const char *uri,
                  const char *values) {
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    static const fmi2CallbackFunctions callbacks = {NULL, calloc, free, NULL, NULL};
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2SetupExperiment", &setup);
    find(library, "fmi2EnterInitializationMode", &enter);
    find(library, "fmi2ExitInitializationMode", &leave);
    find(library, "fmi2DoStep", &s->do_step);
    find(library, "fmi2GetReal", &s->get_real);
    find(library, "fmi2SetReal", &s->set_real);
    find(library, "fmi2GetVersion", &s->get_version);
    s->component = instantiate("timing", fmi2CoSimulation, guid, uri, &callbacks, 0, 0);
    if (!s->component) fail("no instance");
    if (setup(s->component, 0, 0.0, 0.0, 0, 0.0) > fmi2Warning || enter(s->component) > fmi2Warning)
        fail("no initialization");
    while (*values) {
        char *end;
        fmi2ValueReference reference = (fmi2ValueReference)strtoul(values, &end, 10);
        double value;
        if (end == values || *end != '=') fail("a start value is not REF=VALUE");
        value = strtod(values = end + 1, &end);
        if (end == values || (*end && *end != ',')) fail("a start value is not a number");
        if (s->set_real(s->component, &reference, 1, &value) > fmi2Warning) fail("a start value");
        values = *end ? end + 1 : end;
    }
    if (leave(s->component) > fmi2Warning) fail("no start");
    /* What is read and set is that of a model that runs. */
    if (s->do_step(s->component, 0.0, s->step, fmi2True) > fmi2Warning) fail("no step");
    s->done = 1;
}

static double now(void) {
    struct timespec t;
    /* Of this thread alone: what else the machine does should not count. */
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static double run(struct subject *s, long count) {
    fmi2Status worst = fmi2OK, status;
    double value = 0.0, slope = (s->high - s->low) / 65536.0, begin = now();
    long first = s->done;
#define EACH(call) \
    for (long k = first; k < first + count; k++) { \
        status = call; \
        if (status > worst) worst = status; \
    }
    if (!strcmp(s->kind, "bare") || !strcmp(s->kind, "step")) {
        EACH(s->do_step(s->component, (double)k * s->step, s->step, fmi2True))
        s->done += count;
    } else if (!strcmp(s->kind, "setstep")) {
        /* Never the same as before. */
        EACH((value = s->low + (double)(k % 65536) * slope,
              (void)s->set_real(s->component, &s->reference, 1, &value),
              s->do_step(s->component, (double)k * s->step, s->step, fmi2True)))
        s->done += count;
    } else if (!strcmp(s->kind, "get")) {
        EACH(s->get_real(s->component, &s->reference, 1, &value))
    } else if (!strcmp(s->kind, "set")) {
        EACH((value = s->low + (double)(k % 65536) * slope,
              s->set_real(s->component, &s->reference, 1, &value)))
    } else {
        EACH(s->get_version() ? fmi2OK : fmi2Error)
    }
    if (worst > fmi2Warning) fail(s->kind);
    return (now() - begin) / (double)count;
}

enum { FIELDS = 10 };

/* Splits a line at its tabs. strtok would take two tabs for one, and so lose an empty field. */
static void split(char *line, char *field[FIELDS]) {
    line[strcspn(line, "\n")] = 0;
    for (int i = 0; i < FIELDS; i++) {
        char *end = line + strcspn(line, "\t");
        field[i] = line;
        if (i < FIELDS - 1 && !*end) fail("a field is missing");
        if (i == FIELDS - 1 && *end) fail("a field too many");
        *end = 0;
        line = end + 1;
    }
}

int main(int argc, char **argv) {
    static char line[1 << 16];
    int count = 0, rounds = argc > 1 ? atoi(argv[1]) : 15;
    while (fgets(line, sizeof line, stdin)) {
        struct subject *s = &subjects[count];
        char *field[FIELDS];
        void *library;
        if (count++ == MOST) fail("too many subjects");
        split(line, field);
        strncpy(s->kind, field[0], sizeof s->kind - 1);
        s->step = atof(field[4]);
        s->count = atol(field[5]);
        s->reference = (fmi2ValueReference)strtoul(field[6], NULL, 10);
        s->low = atof(field[7]);
        s->high = atof(field[8]);
        library = dlopen(field[1], RTLD_NOW | RTLD_LOCAL);
        if (!library) fail(dlerror());
        if (!strcmp(s->kind, "bare")) {
            find(library, field[2], &s->do_step);
        } else {
            start(s, library, field[2], field[3], field[9]);
        }
        run(s, s->count / 10 + 1);
    }
    for (int round = 0; round < rounds; round++) {
        for (int i = 0; i < count; i++) printf(" %.3f", run(&subjects[i], subjects[i].count));
        printf("\n");
        fflush(stdout);
    }
    return 0;
}
