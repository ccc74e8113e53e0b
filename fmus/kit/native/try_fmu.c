/* Tries an FMU in a process that is no Python: `try_fmu LIBRARY RESOURCES_URI GUID STEP`, for `aeroslosh doctor`.

   Prints what the FMU says, "python: EXECUTABLE VERSION" of the Python that it took, and "runs" after a step.
   Exit code: 0 all well, 1 it cannot be loaded, 3 it refused or failed. */

#include <dlfcn.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *Component;
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

static void say(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    printf("%s\n", message); /* the FMU's own name of a percent sign is two of them */
}

static void *library;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (found == NULL) {
        printf("%s\n", dlerror());
        exit(1);
    }
    return found;
}

/* Which Python it was. */
static void name_python(void) {
    int (*ensure)(void), (*run)(const char *);
    void (*release)(int);
    *(void **)&ensure = dlsym(RTLD_DEFAULT, "PyGILState_Ensure");
    *(void **)&run = dlsym(RTLD_DEFAULT, "PyRun_SimpleString");
    *(void **)&release = dlsym(RTLD_DEFAULT, "PyGILState_Release");
    if (ensure == NULL || run == NULL || release == NULL) return;
    fflush(stdout);
    int state = ensure();
    run("import sys; print('python:', sys.executable, sys.version.split()[0], flush=True)");
    release(state);
}

int main(int argc, char **argv) {
    static const Callbacks callbacks = {say, calloc, free, NULL, NULL};
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    void (*release)(Component);
    int (*set_up)(Component, int, double, double, int, double), (*enter)(Component), (*leave)(Component);
    int (*step)(Component, double, double, int);
    if (argc != 5) return 1;
    if ((library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL)) == NULL) {
        printf("%s\n", dlerror());
        return 1;
    }
    *(void **)&instantiate = function("fmi2Instantiate");
    *(void **)&release = function("fmi2FreeInstance");
    *(void **)&set_up = function("fmi2SetupExperiment");
    *(void **)&enter = function("fmi2EnterInitializationMode");
    *(void **)&leave = function("fmi2ExitInitializationMode");
    *(void **)&step = function("fmi2DoStep");
    Component one = instantiate("doctor", 1, argv[3], argv[2], &callbacks, 0, 0);
    if (one == NULL) return 3;
    name_python();
    if (set_up(one, 0, 0.0, 0.0, 0, 0.0) > 1 || enter(one) > 1 || leave(one) > 1 || step(one, 0.0, atof(argv[4]), 1) > 1) return 3;
    release(one);
    printf("runs\n");
    return 0;
}
