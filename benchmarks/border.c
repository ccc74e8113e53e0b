/* What calls at the border of an FMU cost a host in C: `border LIBRARY URI GUID INPUTS OUTPUTS CALLS`.

   Prints nanoseconds of fmi2GetReal, of fmi2SetReal and of fmi2DoStep, the best of several rounds. */

#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

enum { MOST = 64, ROUNDS = 9 };

static void say(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

static size_t references(const char *list, unsigned *into) {
    size_t count = 0;
    char *end;
    for (const char *at = list; *at && count < MOST; at = *end ? end + 1 : end) into[count++] = (unsigned)strtoul(at, &end, 10);
    return count;
}

int main(int argc, char **argv) {
    static const Callbacks callbacks = {say, calloc, free, NULL, NULL};
    unsigned inputs[MOST], outputs[MOST];
    double values[MOST] = {0.0}, best[3] = {1e30, 1e30, 1e30};
    if (argc != 7) return 1;
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) return fprintf(stderr, "%s\n", dlerror()), 1;
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    int (*set_up)(Component, int, double, double, int, double), (*enter)(Component), (*leave)(Component);
    int (*get)(Component, const unsigned *, size_t, double *), (*set)(Component, const unsigned *, size_t, const double *);
    int (*step)(Component, double, double, int), bad = 0;
    *(void **)&instantiate = dlsym(library, "fmi2Instantiate");
    *(void **)&set_up = dlsym(library, "fmi2SetupExperiment");
    *(void **)&enter = dlsym(library, "fmi2EnterInitializationMode");
    *(void **)&leave = dlsym(library, "fmi2ExitInitializationMode");
    *(void **)&get = dlsym(library, "fmi2GetReal");
    *(void **)&set = dlsym(library, "fmi2SetReal");
    *(void **)&step = dlsym(library, "fmi2DoStep");
    const size_t given = references(argv[4], inputs), taken = references(argv[5], outputs);
    const long calls = atol(argv[6]);
    Component one = instantiate("border", 1, argv[3], argv[2], &callbacks, 0, 0);
    if (one == NULL || set_up(one, 0, 0.0, 0.0, 0, 0.0) || enter(one) || leave(one)) return 3;
    long number = 0;
    for (int round = 0; round < ROUNDS; round++) {
        double spent[3], begin = now();
        for (long i = 0; i < calls; i++) bad |= get(one, outputs, taken, values);
        spent[0] = now() - begin, begin = now();
        for (long i = 0; i < calls; i++) bad |= set(one, inputs, given, values);
        spent[1] = now() - begin, begin = now();
        for (long i = 0; i < calls; i++, number++) bad |= step(one, (double)number * 1e-3, 1e-3, 1);
        spent[2] = now() - begin;
        for (int i = 0; i < 3; i++)
            if (spent[i] / (double)calls < best[i]) best[i] = spent[i] / (double)calls;
    }
    printf("%.0f %.0f %.0f\n", best[0], best[1], best[2]);
    fflush(stdout);
    _Exit(bad ? 3 : 0); /* pythonfmu's binary may not survive an ordinary end */
}
