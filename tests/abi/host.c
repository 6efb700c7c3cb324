/* A plain importer in C99: runs one FMU of FMI 2.0 for Co-Simulation and prints what it reads.
 *
 *   host LIBRARY GUID RESOURCE_URI STEP COUNT [WORD...]
 *
 * RESOURCE_URI may be "-" for NULL. REF is a value reference: digits for a Real, i and digits for
 * an Integer, b and digits for a Boolean. The words:
 *
 *   REF=VALUE      set in initialization mode
 *   REF~AMPLITUDE  a Real input that is set before each step: a triangle wave, period 64 steps
 *   REF            read and printed after initialization and after each step
 *   first=K        the first step is step K (default 0), and the start time K * STEP
 *   save=FILE      after the last step, writes the serialized FMU state
 *   load=FILE      starts from that state, not from an initialization
 *   cycles=N       first makes, starts, steps and frees N other instances
 *   locale=NAME    calls setlocale(LC_ALL, NAME) first, and tells the decimal point on stderr
 *   traps          from the first instance on a division by zero, an invalid operation or an overflow
 *                  ends the process (glibc)
 *   reset          after the run resets the instance and runs again
 *   calls          at last calls all 34 functions once more, and prints each status
 *
 * A line of the output is the time and what was read, as hexadecimal floating-point numbers: the
 * same bits give the same text on each platform. Log messages go to stderr. The exit status is 0
 * if every call of the run gave fmi2OK or fmi2Warning, 1 if not, 2 for bad arguments.
 *
 * The types are those of the official headers (beside this file, in fmi2), and no others:
 *   cc -std=c99 -I tests/abi/fmi2 tests/abi/host.c -o host -ldl -lm
 *   x86_64-w64-mingw32-gcc -std=c99 -I tests/abi/fmi2 tests/abi/host.c -o host.exe
 */
#ifdef __linux__
#define _GNU_SOURCE /* feenableexcept */
#endif
#include "fmi2Functions.h"

#include <locale.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __GLIBC__
#include <fenv.h>
#endif
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#include <windows.h>
#else
#include <dlfcn.h>
#endif

/* Every function of the interface for co-simulation. */
#define FUNCTIONS(each) \
    each(GetTypesPlatform) each(GetVersion) each(SetDebugLogging) each(Instantiate) \
    each(FreeInstance) each(SetupExperiment) each(EnterInitializationMode) \
    each(ExitInitializationMode) each(Terminate) each(Reset) each(GetReal) each(GetInteger) \
    each(GetBoolean) each(GetString) each(SetReal) each(SetInteger) each(SetBoolean) \
    each(SetString) each(GetFMUstate) each(SetFMUstate) each(FreeFMUstate) \
    each(SerializedFMUstateSize) each(SerializeFMUstate) each(DeSerializeFMUstate) \
    each(GetDirectionalDerivative) each(SetRealInputDerivatives) each(GetRealOutputDerivatives) \
    each(DoStep) each(CancelStep) each(GetStatus) each(GetRealStatus) each(GetIntegerStatus) \
    each(GetBooleanStatus) each(GetStringStatus)

#define MEMBER(name) fmi2##name##TYPE *name;
static struct { FUNCTIONS(MEMBER) } fmu;

static void *open_library(const char *path) {
#ifdef _WIN32
    return (void *)LoadLibraryA(path);
#else
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    return library;
#endif
}

static void close_library(void *library) {
#ifdef _WIN32
    FreeLibrary((HMODULE)library);
#else
    dlclose(library);
#endif
}

/* Puts the address of a function into a pointer to a function. */
static int find(void *library, const char *name, void *function, size_t size) {
#ifdef _WIN32
    FARPROC address = GetProcAddress((HMODULE)library, name);
#else
    void *address = dlsym(library, name);
#endif
    if (!address || size != sizeof address) {
        fprintf(stderr, "there is no %s in the library\n", name);
        return 0;
    }
    memcpy(function, &address, size);
    return 1;
}

static int find_all(void *library) {
    int found = 1;
#define FIND(name) found &= find(library, "fmi2" #name, &fmu.name, sizeof fmu.name);
    FUNCTIONS(FIND)
    return found;
}

/* As the standard has it, the message is a format of printf. */
static void logger(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    va_list arguments;
    (void)environment;
    fprintf(stderr, "[%s][%d][%s] ", instance, (int)status, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void *allocate(size_t count, size_t size) { return calloc(count, size); }

enum { MOST_WORDS = 256 };
enum action { SET, WAVE, READ };

struct word {
    enum action action;
    char kind; /* r, i or b */
    fmi2ValueReference reference;
    double value;
};

static struct word words[MOST_WORDS];
static size_t word_count;
static double step_size;
static long step_count, first_step, cycles;
static const char *save_file, *load_file, *locale_name;
static int with_reset, with_calls, with_traps;

static int parse_word(const char *text) {
    struct word *word = &words[word_count];
    char *end;
    if (!strncmp(text, "first=", 6)) return first_step = strtol(text + 6, NULL, 10), 1;
    if (!strncmp(text, "cycles=", 7)) return cycles = strtol(text + 7, NULL, 10), 1;
    if (!strncmp(text, "save=", 5)) return save_file = text + 5, 1;
    if (!strncmp(text, "load=", 5)) return load_file = text + 5, 1;
    if (!strncmp(text, "locale=", 7)) return locale_name = text + 7, 1;
    if (!strcmp(text, "traps")) return with_traps = 1;
    if (!strcmp(text, "reset")) return with_reset = 1;
    if (!strcmp(text, "calls")) return with_calls = 1;
    if (word_count == MOST_WORDS) return 0;
    word->kind = (*text == 'i' || *text == 'b') ? *text++ : 'r';
    word->reference = (fmi2ValueReference)strtoul(text, &end, 10);
    if (end == text) return 0;
    word->action = *end == '=' ? SET : *end == '~' ? WAVE : READ;
    if (*end) {
        text = end + 1;
        word->value = strtod(text, &end);
        if (word->action == READ || end == text || *end) return 0;
    }
    if (word->action == WAVE && word->kind != 'r') return 0;
    word_count++;
    return 1;
}

static int failed;

/* Notes a call that gave neither fmi2OK nor fmi2Warning. */
static void check(const char *name, fmi2Status status) {
    if (status == fmi2OK || status == fmi2Warning) return;
    fprintf(stderr, "%s gave %d\n", name, (int)status);
    failed = 1;
}
#define CALL(name, ...) check("fmi2" #name, fmu.name(__VA_ARGS__))

/* Not "%a", of which each C library has its own idea. */
static void print_number(double value) {
    uint64_t bits;
    unsigned long high, low;
    int exponent;
    memcpy(&bits, &value, sizeof bits);
    high = (unsigned long)(bits >> 32 & 0xfffff);
    low = (unsigned long)(bits & 0xffffffff);
    exponent = (int)(bits >> 52 & 0x7ff);
    fputs(bits >> 63 ? " -" : " +", stdout);
    if (exponent == 0x7ff) {
        fputs(high || low ? "nan" : "inf", stdout);
    } else if (exponent == 0) {
        printf("0x0.%05lx%08lxp%+d", high, low, high || low ? -1022 : 0);
    } else {
        printf("0x1.%05lx%08lxp%+d", high, low, exponent - 1023);
    }
}

static void set(fmi2Component c, const struct word *word, double value) {
    fmi2Integer integer = (fmi2Integer)value;
    fmi2Boolean boolean = value != 0.0;
    switch (word->kind) {
    case 'r': CALL(SetReal, c, &word->reference, 1, &value); break;
    case 'i': CALL(SetInteger, c, &word->reference, 1, &integer); break;
    default: CALL(SetBoolean, c, &word->reference, 1, &boolean);
    }
}

static double get(fmi2Component c, const struct word *word) {
    fmi2Real real = 0.0;
    fmi2Integer integer = 0;
    fmi2Boolean boolean = 0;
    switch (word->kind) {
    case 'r': CALL(GetReal, c, &word->reference, 1, &real); return real;
    case 'i': CALL(GetInteger, c, &word->reference, 1, &integer); return integer;
    default: CALL(GetBoolean, c, &word->reference, 1, &boolean); return boolean;
    }
}

static void print_line(fmi2Component c, double time) {
    print_number(time);
    for (size_t i = 0; i < word_count; i++) {
        if (words[i].action == READ) print_number(get(c, &words[i]));
    }
    putchar('\n');
}

/* From -1 to 1 and back in 64 steps; each value is exact. */
static double wave(long step) {
    long phase = step % 64;
    return (phase < 32 ? phase : 64 - phase) / 16.0 - 1.0;
}

static void load(fmi2Component c) {
    static char bytes[1 << 20];
    fmi2FMUstate state = NULL;
    FILE *file = fopen(load_file, "rb");
    size_t size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file) fclose(file);
    CALL(DeSerializeFMUstate, c, bytes, size, &state);
    CALL(SetFMUstate, c, state);
    CALL(FreeFMUstate, c, &state);
}

static void save(fmi2Component c) {
    fmi2FMUstate state = NULL;
    size_t size = 0;
    char *bytes;
    FILE *file = fopen(save_file, "wb");
    CALL(GetFMUstate, c, &state);
    CALL(SerializedFMUstateSize, c, state, &size);
    bytes = malloc(size ? size : 1);
    CALL(SerializeFMUstate, c, state, bytes, size);
    CALL(FreeFMUstate, c, &state);
    if (!file || fwrite(bytes, 1, size, file) != size) failed = 1;
    if (file) fclose(file);
    free(bytes);
}

static void run(fmi2Component c) {
    double start = (double)first_step * step_size;
    if (load_file) {
        load(c);
    } else {
        CALL(SetupExperiment, c, fmi2False, 0.0, start, fmi2False, 0.0);
        CALL(EnterInitializationMode, c);
        for (size_t i = 0; i < word_count; i++) {
            if (words[i].action == SET) set(c, &words[i], words[i].value);
        }
        CALL(ExitInitializationMode, c);
    }
    print_line(c, start);
    for (long k = first_step; k < first_step + step_count && !failed; k++) {
        for (size_t i = 0; i < word_count; i++) {
            if (words[i].action == WAVE) set(c, &words[i], words[i].value * wave(k));
        }
        CALL(DoStep, c, (double)k * step_size, step_size, fmi2True);
        print_line(c, (double)(k + 1) * step_size);
    }
}

/* Calls every function once through its type in the header. Last, what leads to the error state. */
static void call_all(fmi2Component c) {
    static char bytes[1 << 20];
    fmi2FMUstate state = NULL;
    fmi2ValueReference reference = 0;
    fmi2Real real = 1.0;
    fmi2Integer integer = 1;
    fmi2Boolean boolean = 1;
    fmi2String text = "text";
    fmi2Status status = fmi2OK;
    size_t size = 0;
#define SAY(name, ...) printf("fmi2" #name " %d\n", (int)fmu.name(__VA_ARGS__))
#define SAY_RECOVERED(name, ...) \
    SAY(name, __VA_ARGS__); CALL(SetFMUstate, c, state)
    printf("fmi2GetTypesPlatform %s\n", fmu.GetTypesPlatform());
    printf("fmi2GetVersion %s\n", fmu.GetVersion());
    SAY(SetDebugLogging, c, fmi2False, 0, NULL);
    SAY(GetFMUstate, c, &state);
    SAY(SetFMUstate, c, state);
    SAY(GetStatus, c, fmi2DoStepStatus, &status);
    SAY(GetRealStatus, c, fmi2LastSuccessfulTime, &real);
    SAY(GetIntegerStatus, c, fmi2DoStepStatus, &integer);
    SAY(GetBooleanStatus, c, fmi2Terminated, &boolean);
    SAY(GetStringStatus, c, fmi2PendingStatus, &text);
    SAY(DoStep, c, (double)(first_step + step_count) * step_size, step_size, fmi2False);
    /* No elements: fine for each type. */
    SAY(GetReal, c, &reference, 0, &real);
    SAY(GetInteger, c, &reference, 0, &integer);
    SAY(GetBoolean, c, &reference, 0, &boolean);
    SAY(GetString, c, &reference, 0, &text);
    SAY(SetReal, c, &reference, 0, &real);
    SAY(SetInteger, c, &reference, 0, &integer);
    SAY(SetBoolean, c, &reference, 0, &boolean);
    SAY(SetString, c, &reference, 0, &text);
    /* Supported where the description says so. */
    SAY_RECOVERED(SerializedFMUstateSize, c, state, &size);
    SAY_RECOVERED(SerializeFMUstate, c, state, bytes, size);
    {
        fmi2FMUstate copy = NULL;
        SAY_RECOVERED(DeSerializeFMUstate, c, bytes, size, &copy);
        if (copy) CALL(FreeFMUstate, c, &copy);
    }
    SAY_RECOVERED(GetDirectionalDerivative, c, &reference, 0, &reference, 0, &real, &real);
    SAY_RECOVERED(SetRealInputDerivatives, c, &reference, 0, &integer, &real);
    SAY_RECOVERED(GetRealOutputDerivatives, c, &reference, 0, &integer, &real);
    SAY_RECOVERED(CancelStep, c);
    SAY(FreeFMUstate, c, &state);
    SAY(Terminate, c);
    SAY(Reset, c);
    SAY(SetupExperiment, c, fmi2True, 1e-6, 0.0, fmi2True, 1.0);
    SAY(EnterInitializationMode, c);
    SAY(ExitInitializationMode, c);
}

static fmi2Component instantiate(char **arguments) {
    /* On the stack: an FMU has to copy it. */
    fmi2CallbackFunctions callbacks = {logger, allocate, free, NULL, NULL};
    const char *location = strcmp(arguments[3], "-") ? arguments[3] : NULL;
    return fmu.Instantiate("host", fmi2CoSimulation, arguments[2], location, &callbacks, fmi2False,
                           fmi2False);
}

static void cycle(char **arguments) {
    fmi2FMUstate state = NULL;
    fmi2Component c = instantiate(arguments);
    CALL(SetupExperiment, c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    CALL(EnterInitializationMode, c);
    CALL(ExitInitializationMode, c);
    CALL(DoStep, c, 0.0, step_size, fmi2True);
    CALL(GetFMUstate, c, &state);
    CALL(SetFMUstate, c, state);
    CALL(FreeFMUstate, c, &state);
    fmu.FreeInstance(c);
}

int main(int count, char **arguments) {
    fmi2Component c;
    void *library;
    if (count < 6) return fprintf(stderr, "host LIBRARY GUID URI STEP COUNT [WORD...]\n"), 2;
    step_size = strtod(arguments[4], NULL);
    step_count = strtol(arguments[5], NULL, 10);
    for (int i = 6; i < count; i++) {
        if (!parse_word(arguments[i])) return fprintf(stderr, "bad word %s\n", arguments[i]), 2;
    }
    /* Only now: strtod reads by the locale. */
    if (locale_name) {
        if (!setlocale(LC_ALL, locale_name)) return fprintf(stderr, "no such locale\n"), 2;
        fprintf(stderr, "decimal point %s\n", localeconv()->decimal_point);
    }
#ifdef _WIN32
    _setmode(_fileno(stdout), _O_BINARY);
#endif
    library = open_library(arguments[1]);
    if (!library || !find_all(library)) return fprintf(stderr, "no library\n"), 2;
    if (strcmp(fmu.GetTypesPlatform(), fmi2TypesPlatform) || strcmp(fmu.GetVersion(), fmi2Version))
        return fprintf(stderr, "another platform or version\n"), 1;
#ifdef __GLIBC__
    if (with_traps) feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
#endif
    for (long k = 0; k < cycles && !failed; k++) cycle(arguments);
    c = instantiate(arguments);
    if (!c) return fprintf(stderr, "no instance\n"), 1;
    run(c);
    if (with_reset && !failed) {
        CALL(Reset, c);
        run(c);
    }
    if (save_file && !failed) save(c);
    if (with_calls && !failed) {
        call_all(c);
    } else if (!failed) {
        CALL(Terminate, c);
    }
    fmu.FreeInstance(c);
    close_library(library);
    return failed;
}
