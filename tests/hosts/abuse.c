/* A C program that does to one FMU what hosts do and what they must not do: `abuse LIBRARY URI GUID INPUTS OUTPUTS MODE [NUMBERS]`.

   INPUTS and OUTPUTS are value references of Reals, separated by commas. Modes:
   threads N      N threads, each with an instance of its own, then one instance through N threads in turn: the same numbers
   fork           a child that goes on with the instance and ends by exit; another with a thread in the FMU meanwhile
   reload N       dlopen, an instance, dlclose, N times
   fuzz SEED N    N calls of any function with any argument, good and bad
   many N         N instances one after another; prints resident memory in kB after a tenth of them and at the end
   interrupt      sends itself SIGINT after a step: the default action must end it
   copies OTHER URI GUID   a second library beside the first: an instance of each, in turn

   Exit code 0 where all was as it must be; 1 with a line that says what was not. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef void *Component;
typedef void *State;
typedef unsigned Reference;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

#define FUNCTIONS(X)                                                                                          \
    X(Component, Instantiate, (const char *, int, const char *, const char *, const Callbacks *, int, int))   \
    X(void, FreeInstance, (Component))                                                                        \
    X(int, SetDebugLogging, (Component, int, size_t, const char *const *))                                    \
    X(int, SetupExperiment, (Component, int, double, double, int, double))                                    \
    X(int, EnterInitializationMode, (Component))                                                              \
    X(int, ExitInitializationMode, (Component))                                                               \
    X(int, Terminate, (Component))                                                                            \
    X(int, Reset, (Component))                                                                                \
    X(int, DoStep, (Component, double, double, int))                                                          \
    X(int, CancelStep, (Component))                                                                           \
    X(int, GetReal, (Component, const Reference *, size_t, double *))                                         \
    X(int, SetReal, (Component, const Reference *, size_t, const double *))                                   \
    X(int, GetInteger, (Component, const Reference *, size_t, int *))                                         \
    X(int, SetInteger, (Component, const Reference *, size_t, const int *))                                   \
    X(int, GetBoolean, (Component, const Reference *, size_t, int *))                                         \
    X(int, SetBoolean, (Component, const Reference *, size_t, const int *))                                   \
    X(int, GetString, (Component, const Reference *, size_t, const char **))                                  \
    X(int, SetString, (Component, const Reference *, size_t, const char *const *))                            \
    X(int, GetFMUstate, (Component, State *))                                                                 \
    X(int, SetFMUstate, (Component, State))                                                                   \
    X(int, FreeFMUstate, (Component, State *))                                                                \
    X(int, SerializedFMUstateSize, (Component, State, size_t *))                                              \
    X(int, SerializeFMUstate, (Component, State, char *, size_t))                                             \
    X(int, DeSerializeFMUstate, (Component, const char *, size_t, State *))                                   \
    X(int, GetStatus, (Component, int, int *))                                                                \
    X(int, GetRealStatus, (Component, int, double *))                                                         \
    X(int, GetIntegerStatus, (Component, int, int *))                                                         \
    X(int, GetBooleanStatus, (Component, int, int *))                                                         \
    X(int, GetStringStatus, (Component, int, const char **))                                                  \
    X(int, SetRealInputDerivatives, (Component, const Reference *, size_t, const int *, const double *))      \
    X(int, GetRealOutputDerivatives, (Component, const Reference *, size_t, const int *, double *))           \
    X(int, GetDirectionalDerivative,                                                                          \
      (Component, const Reference *, size_t, const Reference *, size_t, const double *, double *))
#define DECLARE(type, name, arguments) type(*name) arguments;
typedef struct {
    void *handle;
    const char *uri, *guid;
    FUNCTIONS(DECLARE)
} Library;

enum { MOST = 64, STEPS = 8 };
static Library fmu;
static Reference inputs[MOST], outputs[MOST];
static size_t input_count, output_count;
static long told;

static void stop(const char *what, long number) {
    printf("%s (%ld)\n", what, number);
    fflush(stdout);
    _exit(1);
}

static void logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    (void)environment;
    if (instance == NULL || category == NULL || message == NULL || status < 0 || status > 3) stop("a message without its parts", status);
    __atomic_add_fetch(&told, (long)strlen(message) > 0, __ATOMIC_RELAXED);
}

static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};

static Library load(const char *path, const char *uri, const char *guid) {
    Library library;
    memset(&library, 0, sizeof library);
    library.handle = dlopen(path, RTLD_NOW | RTLD_LOCAL), library.uri = uri, library.guid = guid;
    if (library.handle == NULL) stop(dlerror(), 0);
#define RESOLVE(type, name, arguments) \
    if ((*(void **)&library.name = dlsym(library.handle, "fmi2" #name)) == NULL) stop("no fmi2" #name, 0);
    FUNCTIONS(RESOLVE)
    return library;
}

static Component start(const Library *of, const char *name) {
    Component one = of->Instantiate(name, 1, of->guid, of->uri, &callbacks, 0, 0);
    if (one == NULL) stop("no instance", 0);
    if (of->SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0) || of->EnterInitializationMode(one) || of->ExitInitializationMode(one))
        stop("not initialised", 0);
    return one;
}

/* One step with its own inputs; adds the outputs to `sum`. */
static void step(Component one, int number, double share, double *sum) {
    double values[MOST];
    for (size_t i = 0; i < input_count; i++) values[i] = share * 1e-3 * (double)(i + 1) * (number + 1);
    if (fmu.SetReal(one, inputs, input_count, values)) stop("inputs not set", number);
    if (fmu.DoStep(one, number * 1e-3, 1e-3, 1)) stop("step not done", number);
    if (fmu.GetReal(one, outputs, output_count, values)) stop("outputs not read", number);
    for (size_t i = 0; i < output_count; i++) *sum += values[i] * (double)(i + 1);
}

static void *life(void *data) {
    double *sum = data, share = *sum;
    Component one = start(&fmu, "life");
    *sum = 0.0;
    for (int i = 0; i < STEPS; i++) step(one, i, share, sum);
    if (fmu.Terminate(one)) stop("not terminated", 0);
    fmu.FreeInstance(one);
    return NULL;
}

typedef struct {
    Component one;
    int number;
    double sum;
} Turn;

static void *turn(void *data) {
    Turn *it = data;
    step(it->one, it->number, 1.0, &it->sum);
    return NULL;
}

static void threads(int count) {
    double alone[2] = {1.0, 0.5}, sums[MOST];
    pthread_t made[MOST];
    life(&alone[0]);
    life(&alone[1]);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < count; i++) sums[i] = i % 2 ? 0.5 : 1.0;
        for (int i = 0; i < count; i++) pthread_create(&made[i], NULL, life, &sums[i]);
        for (int i = 0; i < count; i++) pthread_join(made[i], NULL);
        for (int i = 0; i < count; i++)
            if (sums[i] != alone[i % 2]) stop("another number in a thread", i);
    }
    Turn it = {start(&fmu, "turns"), 0, 0.0};
    for (; it.number < STEPS; it.number++) {
        pthread_create(&made[0], NULL, turn, &it);
        pthread_join(made[0], NULL);
    }
    if (it.sum != alone[0]) stop("another number in turns", 0);
    fmu.FreeInstance(it.one);
}

static int running = 1;

static void *work(void *data) {
    double share = 1.0;
    (void)data;
    while (__atomic_load_n(&running, __ATOMIC_ACQUIRE)) life(&share), share = 1.0;
    return NULL;
}

static void forks(void) {
    double before = 0.0, after = 0.0;
    Component one = start(&fmu, "fork");
    for (int i = 0; i < 2; i++) step(one, i, 1.0, &before);
    for (int round = 0; round < 12; round++) { /* the first two without, the others with a thread that is in the FMU */
        static pthread_t busy;
        if (round == 2) pthread_create(&busy, NULL, work, NULL);
        State state = NULL;
        if (fmu.GetFMUstate(one, &state)) stop("no state", round);
        fflush(NULL);
        pid_t child = fork();
        if (child == 0) {
            alarm(20);
            double sum = 0.0, share = 1.0;
            for (int i = 2; i < 5; i++) step(one, i, 1.0, &sum);
            life(&share);
            if (round % 2) _exit(sum != 0.0 ? 7 : 1);
            exit(sum != 0.0 ? 7 : 1);
        }
        int status = 0;
        waitpid(child, &status, 0);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != 7) stop("the child ended otherwise", status);
        if (fmu.SetFMUstate(one, state) || fmu.FreeFMUstate(one, &state) || state != NULL) stop("no way back", round);
        after = 0.0;
        step(one, 2, 1.0, &after);
        if (fmu.Reset(one) || fmu.SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0) || fmu.EnterInitializationMode(one) ||
            fmu.ExitInitializationMode(one))
            stop("not reset", round);
        for (int i = 0; i < 2; i++) step(one, i, 1.0, &after);
    }
    __atomic_store_n(&running, 0, __ATOMIC_RELEASE);
    fmu.FreeInstance(one);
    sleep(1); /* the thread ends its life */
}

static unsigned long long seed;

static unsigned any(unsigned below) {
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (unsigned)((seed >> 11) % below);
}

static double number(void) {
    static const double odd[] = {0.0, -0.0, 1.0, -1.0, 1e-3, 1e308, -1e308, 5e-324, NAN, INFINITY, -INFINITY, 1e-9, 0.05};
    return any(2) ? odd[any(sizeof odd / sizeof *odd)] : (any(2001) - 1000.0) * 1e-5;
}

static const char *text(void) {
    static const char *const odd[] = {NULL, "", "x", "%s%n%s", "\xff", "caf\xe9", "\xed\xa0\x80", "a/b #%41\n", "logAll",
                                      "logStatusError", "NACA 0012"};
    return odd[any(sizeof odd / sizeof *odd)];
}

static void *garbage(void) {
    static int something;
    void *const odd[] = {NULL, (void *)1, (void *)8, &something, (void *)~0ull, (void *)(1ull << 63), (void *)((1ull << 63) + 7)};
    return odd[any(sizeof odd / sizeof *odd)];
}

/* Any call: its status; -1 of one that has none. `good`: whether the component is an instance of now. */
static int one_call(unsigned which, Component one, Component *slot, State *states, unsigned known) {
    Reference r[8];
    double x[8];
    int n[8];
    const char *s[8];
    char bytes[512];
    size_t count = any(8), size = 0;
    const int null = any(20) == 0;
    State *state = &states[any(8)], other = any(8) ? *state : garbage();
    for (int i = 0; i < 8; i++) {
        r[i] = any(12) ? any(known) : any(2) ? any(1u << 30) : ~0u - any(3);
        x[i] = number(), n[i] = (int)any(5) - 1 + (any(30) ? 0 : 1 << 30), s[i] = text();
    }
    for (int i = 0; i < 512; i++) bytes[i] = (char)any(256);
    const Reference *rs = null && any(2) ? NULL : r;
    const double times[] = {0.0, 1e-3, 2e-3, 0.01, 5.0};
    switch (which) {
    case 0: {
        if (any(3)) return -1; /* instances are dear */
        const char *uri = any(6) ? fmu.uri : any(2) ? text() : NULL, *guid = any(6) ? fmu.guid : text(), *name = any(6) ? "fuzz" : text();
        Callbacks mine = callbacks;
        if (any(10) == 0) mine.logger = NULL;
        Component made = fmu.Instantiate(name, any(8) ? 1 : (int)any(4) - 1, guid, uri, any(10) ? &mine : NULL, (int)any(2), any(4) == 0);
        memset(&mine, 0x55, sizeof mine); /* it may not live on */
        if (made != NULL) {
            if (any(3)) fmu.FreeInstance(*slot);
            *slot = made;
        }
        return -1;
    }
    case 1: if (any(8) == 0) fmu.FreeInstance(one); return -1;
    case 2: return fmu.SetDebugLogging(one, (int)any(2), null ? count : any(4), null ? NULL : s);
    case 3: return fmu.SetupExperiment(one, (int)any(2), number(), any(2) ? 0.0 : number(), (int)any(2), number());
    case 4: return fmu.EnterInitializationMode(one);
    case 5: return fmu.ExitInitializationMode(one);
    case 6: return any(6) ? -1 : fmu.Terminate(one);
    case 7: return any(3) ? -1 : fmu.Reset(one);
    case 8: return fmu.DoStep(one, any(3) ? times[any(5)] : number(), any(3) ? 1e-3 : number(), (int)any(2));
    case 9: return fmu.CancelStep(one);
    case 10: return fmu.GetReal(one, rs, count, null ? NULL : x);
    case 11: return fmu.SetReal(one, rs, count, null ? NULL : x);
    case 12: return fmu.GetInteger(one, rs, count, null ? NULL : n);
    case 13: return fmu.SetInteger(one, rs, count, null ? NULL : n);
    case 14: return fmu.GetBoolean(one, rs, count, null ? NULL : n);
    case 15: return fmu.SetBoolean(one, rs, count, null ? NULL : n);
    case 16: return fmu.GetString(one, rs, count, null ? NULL : s);
    case 17: return fmu.SetString(one, rs, count, null ? NULL : s);
    case 18: return fmu.GetFMUstate(one, null ? NULL : state);
    case 19: return fmu.SetFMUstate(one, other);
    case 20: return fmu.FreeFMUstate(one, null ? NULL : any(10) ? state : (State *)*state);
    case 21: return fmu.SerializedFMUstateSize(one, other, null ? NULL : &size);
    case 22: {
        static char whole[1 << 20];
        if (fmu.SerializedFMUstateSize(one, other, &size) != 0 || size > sizeof whole) return -1;
        const int status = fmu.SerializeFMUstate(one, other, null ? NULL : whole, any(3) ? size : size + any(9) - 4);
        if (status == 0 && any(2)) whole[any((unsigned)size)] ^= (char)any(2);
        if (status == 0) fmu.DeSerializeFMUstate(one, whole, any(3) ? size : any((unsigned)size), state);
        return status;
    }
    case 23: return fmu.DeSerializeFMUstate(one, null ? NULL : bytes, any(512), null && any(2) ? NULL : state);
    case 24: return fmu.GetStatus(one, (int)any(6) - 1, null ? NULL : n);
    case 25: return fmu.GetRealStatus(one, (int)any(6) - 1, null ? NULL : x);
    case 26: return fmu.GetIntegerStatus(one, (int)any(6) - 1, null ? NULL : n);
    case 27: return fmu.GetBooleanStatus(one, (int)any(6) - 1, null ? NULL : n);
    case 28: return fmu.GetStringStatus(one, (int)any(6) - 1, null ? NULL : s);
    case 29: return fmu.SetRealInputDerivatives(one, rs, count, n, x);
    case 30: return fmu.GetRealOutputDerivatives(one, rs, count, n, x);
    default: return fmu.GetDirectionalDerivative(one, rs, count, rs, count, x, x);
    }
}

static void fuzz(long calls) {
    Component slots[8] = {0};
    State states[8] = {0};
    long seen[6] = {0}, done = 0;
    unsigned known = (unsigned)(output_count + input_count) + 40;
    for (int i = 0; i < 6; i++) slots[i] = start(&fmu, "fuzz");
    for (; done < calls; done++) {
        const unsigned which = any(32), place = any(9);
        if (done % 16 == 0) alarm(60); /* a call that hangs ends the process with SIGALRM */
        Component spare = NULL, *slot = place < 8 ? &slots[place] : &spare;
        const int wild = place == 8;
        if (wild) spare = garbage();
        const int status = one_call(which, wild ? spare : *slot, slot, states, known);
        if (status < -1 || status > 3 || status == 1) stop("a status of nothing", status);
        if (wild && status != -1 && status != 3) stop("a status of no instance", status);
        seen[status + 1]++;
        if (any(200) == 0) { /* back to where steps are made */
            Component *again = &slots[any(6)];
            if (fmu.Reset(*again) != 0) *again = start(&fmu, "again");
            else if (fmu.SetupExperiment(*again, 0, 0.0, 0.0, 0, 0.0) || fmu.EnterInitializationMode(*again) ||
                     fmu.ExitInitializationMode(*again))
                stop("a reset does not cure", done);
        }
    }
    double share = 1.0, calm = 1.0;
    life(&share), life(&calm);
    if (share != calm) stop("two lives differ", 0);
    printf("%ld calls: %ld fmi2OK, %ld fmi2Discard, %ld fmi2Error, %ld messages\n", done, seen[1], seen[3], seen[4], told);
    if (!seen[1] || !seen[3] || !seen[4]) stop("not every status was seen", 0);
}

static long resident(void) {
    long pages = 0, skipped = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file == NULL || fscanf(file, "%ld %ld", &skipped, &pages) != 2) stop("no memory figures", 0);
    fclose(file);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

static void many(long count) {
    long early = 0;
    for (long i = 0; i < count; i++) {
        double sum = 0.0;
        Component one = start(&fmu, "many");
        State state = NULL;
        step(one, 0, 1.0, &sum);
        if (fmu.GetFMUstate(one, &state) || fmu.SetFMUstate(one, state) || fmu.FreeFMUstate(one, &state)) stop("states", i);
        if (fmu.DoStep(one, 9.0, 1e-3, 1) != 3) stop("a step from elsewhere", i);
        fmu.FreeInstance(one);
        if (i == count / 10) early = resident();
    }
    printf("%ld %ld\n", early, resident());
}

static size_t references(const char *list, Reference *into) {
    size_t count = 0;
    char *end;
    for (const char *at = list; *at && count < MOST; at = *end ? end + 1 : end) into[count++] = (Reference)strtoul(at, &end, 10);
    return count;
}

int main(int argc, char **argv) {
    if (argc < 7) return 2;
    fmu = load(argv[1], argv[2], argv[3]);
    input_count = references(argv[4], inputs);
    output_count = references(argv[5], outputs);
    const char *mode = argv[6];
    const long count = argc > 7 ? atol(argv[7]) : 0;
    double sum = 0.0, share = 1.0;
    if (strcmp(mode, "threads") == 0) threads((int)count);
    else if (strcmp(mode, "fork") == 0) forks();
    else if (strcmp(mode, "fuzz") == 0) seed = (unsigned long long)count * 2654435761u + 1, fuzz(atol(argv[8]));
    else if (strcmp(mode, "many") == 0) many(count);
    else if (strcmp(mode, "reload") == 0) {
        for (long i = 0; i < count; i++) {
            life(&share), share = 1.0;
            if (dlclose(fmu.handle)) stop("not unloaded", i);
            fmu = load(argv[1], argv[2], argv[3]);
        }
        dlclose(fmu.handle);
    } else if (strcmp(mode, "interrupt") == 0) {
        signal(SIGINT, SIG_DFL); /* a shell may have had it ignored */
        step(start(&fmu, "interrupt"), 0, 1.0, &sum);
        struct sigaction action;
        sigaction(SIGINT, NULL, &action);
        if (action.sa_handler != SIG_DFL) stop("somebody handles SIGINT", 0);
        raise(SIGINT);
        stop("SIGINT is lost", 0);
    } else if (strcmp(mode, "copies") == 0) {
        Library other = load(argv[7], argv[8], argv[9]);
        Component a = start(&fmu, "a"), b = start(&other, "b");
        State state = NULL;
        step(a, 0, 1.0, &sum);
        if (other.DoStep(b, 0.0, 1e-3, 1) || fmu.GetFMUstate(a, &state)) stop("not side by side", 0);
        if (other.DoStep(a, 1e-3, 1e-3, 1) != 3 || other.SetFMUstate(b, state) != 3) stop("one takes what is the other's", 0);
    } else return 2;
    printf("ended\n");
    return 0;
}
