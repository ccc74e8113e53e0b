/* A co-simulation host in plain C: drives FMI 2.0 FMUs with tables of their inputs and prints their outputs.

   host [OPTIONS] FMU TABLE [NAME=VALUE ...] [+ FMU TABLE [NAME=VALUE ...]] ...

   FMU     folder of an unzipped FMU (binaries/, resources/, modelDescription.xml)
   TABLE   CSV: a header "time,<input>,...", then a row per communication point; the row at the end of a step is what the
           step gets (inputs of aeroslosh's FMUs are values at the end of the step)
   NAME=VALUE   a parameter; an enumeration by its number, a Boolean as true or false

   --rollback ROW      at ROW take the state, go on to the end, return to ROW, go on again and print what comes then
   --save ROW FILE     write the state at ROW of the first FMU to FILE
   --resume ROW FILE   start at ROW with the state in FILE
   --log               show what the FMUs log
   --end HOW           exit (default), unload, or quick: see `finish`

   Exit code: 0 all well, 1 wrong use or an FMU that cannot be loaded, 3 an FMU refused or failed.
   Build: see README.md. */

#define _XOPEN_SOURCE 700
#include <dlfcn.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2FunctionTypes.h"

#define FUNCTIONS(X) \
    X(Instantiate) X(FreeInstance) X(SetupExperiment) X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate) \
    X(DoStep) X(SetReal) X(SetInteger) X(SetBoolean) X(SetString) X(GetReal) X(GetBoolean) X(GetString) \
    X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate) X(SerializedFMUstateSize) X(SerializeFMUstate) X(DeSerializeFMUstate)
#define DECLARE(name) fmi2##name##TYPE *name;

enum { NAMES = 512, LENGTH = 128, MOST = 8 };

typedef struct {
    char name[LENGTH];
    char kind; /* R, I (also enumerations), B, S */
    fmi2ValueReference reference;
} Variable;

typedef struct {
    double *values; /* rows x columns, column 0 is the time [s] */
    int rows, columns;
    char names[NAMES][LENGTH];
} Table;

typedef struct {
    char folder[PATH_MAX], name[2 * LENGTH];
    void *library;
    FUNCTIONS(DECLARE)
    fmi2Component component;
    fmi2CallbackFunctions callbacks; /* FMUs of others may keep the address */
    char *description;
    Variable outputs[NAMES];
    int n_outputs;
    Table table;
    fmi2ValueReference inputs[NAMES]; /* of the table's columns but the first */
    char **settings;
    int n_settings;
} Instance;

static int logging; /* --log */
static int quiet;   /* what an instance says is shown with --log, and where `check` says it anyway not twice */
static const char *STATUS[] = {"OK", "Warning", "Discard", "Error", "Fatal", "Pending"};

/* ---- the end */

/* exit: as programs end; unload: after dlclose; quick: without the C library's handlers, for FMUs of others that cannot stand
   an ordinary end (pythonfmu 0.7's own binary is one). */
static void finish(Instance *instances, int count, const char *how, int code) {
    for (int i = 0; i < count; i++) {
        if (instances[i].component == NULL) continue;
        instances[i].Terminate(instances[i].component);
        instances[i].FreeInstance(instances[i].component);
    }
    fflush(NULL);
    if (strcmp(how, "quick") == 0) _exit(code);
    if (strcmp(how, "unload") == 0)
        for (int i = 0; i < count; i++) dlclose(instances[i].library);
    exit(code);
}

static void stop(int code, const char *format, ...) {
    va_list values;
    va_start(values, format);
    fflush(stdout);
    fprintf(stderr, "host: ");
    vfprintf(stderr, format, values);
    fprintf(stderr, "\n");
    va_end(values);
    fflush(NULL);
    _exit(code);
}

/* ---- modelDescription.xml: enough of XML for what a host needs */

/* Copy attribute `key` of the element that starts at `element` into `value`; 0 when it has none. */
static int attribute(const char *element, const char *key, char *value, size_t size) {
    const char *end = element;
    for (int quoted = 0; *end && (quoted || *end != '>'); end++) quoted ^= *end == '"';
    size_t length = strlen(key);
    for (const char *at = element; (at = strstr(at, key)) != NULL && at < end; at++) {
        if ((at[-1] != ' ' && at[-1] != '\n' && at[-1] != '\t') || at[length] != '=' || at[length + 1] != '"') continue;
        const char *from = at + length + 2, *to = strchr(from, '"');
        if (to == NULL || (size_t)(to - from) >= size) return 0;
        memcpy(value, from, (size_t)(to - from));
        value[to - from] = '\0';
        return 1;
    }
    return 0;
}

/* Visit the variables: 1 with the next one in `variable` and its causality, 0 after the last. */
static int next_variable(const char **at, Variable *variable, char causality[LENGTH]) {
    char reference[LENGTH];
    const char *element = strstr(*at, "<ScalarVariable");
    if (element == NULL) return 0;
    *at = element + 1;
    if (!attribute(element, "causality", causality, LENGTH)) strcpy(causality, "local");
    if (!attribute(element, "name", variable->name, LENGTH) || !attribute(element, "valueReference", reference, LENGTH))
        stop(1, "modelDescription.xml: a variable without name or valueReference");
    variable->reference = (fmi2ValueReference)strtoul(reference, NULL, 10);
    const char *types[] = {"<Real", "<Integer", "<Enumeration", "<Boolean", "<String"}, *nearest = NULL;
    for (int i = 0; i < 5; i++) {
        const char *type = strstr(element, types[i]);
        if (type != NULL && (nearest == NULL || type < nearest)) {
            nearest = type;
            variable->kind = "RIIBS"[i];
        }
    }
    return 1;
}

static int find(const Instance *it, const char *name, Variable *variable) {
    char causality[LENGTH];
    const char *at = it->description;
    while (next_variable(&at, variable, causality))
        if (strcmp(variable->name, name) == 0) return 1;
    return 0;
}

static char *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (file == NULL) stop(1, "%s cannot be read; give an unzipped FMU, and files that exist", path);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *text = malloc(*size + 1);
    if (text == NULL || fread(text, 1, *size, file) != *size) stop(1, "%s cannot be read", path);
    text[*size] = '\0';
    fclose(file);
    return text;
}

static void read_table(Table *table, const char *path) {
    size_t size;
    char *text = read_file(path, &size), *rest = text, *line = strtok_r(rest, "\r\n", &rest), *cell, *inner;
    if (line == NULL || strncmp(line, "time", 4) != 0) stop(1, "%s: the first column of the header must be time", path);
    for (cell = strtok_r(line, ",", &inner); cell != NULL; cell = strtok_r(NULL, ",", &inner)) {
        if (table->columns == NAMES || strlen(cell) >= LENGTH) stop(1, "%s: too many columns, or a name too long", path);
        strcpy(table->names[table->columns++], cell);
    }
    table->values = malloc((size / 2 + 1) * sizeof(double)); /* a cell has at least one character and a separator */
    if (table->values == NULL) stop(1, "no memory");
    while ((line = strtok_r(NULL, "\r\n", &rest)) != NULL) {
        char *at = line, *end;
        for (int i = 0; i < table->columns; i++, at = end + 1) {
            table->values[table->rows * table->columns + i] = strtod(at, &end);
            if (end == at || (*end != ',' && i + 1 < table->columns))
                stop(1, "%s: row %d is no row of numbers", path, table->rows + 1);
        }
        table->rows++;
    }
    free(text);
    if (table->rows < 2) stop(1, "%s: two rows at least", path);
}

/* ---- FMI calls */

/* What a user sees of a bad status: our FMUs say in the output `error` what happened and what to do. */
static void check(Instance *it, const char *call, fmi2Status status) {
    Variable variable;
    fmi2String error = "";
    if (status <= fmi2Warning) return;
    if (find(it, "error", &variable) && variable.kind == 'S') it->GetString(it->component, &variable.reference, 1, &error);
    if (strncmp(error, it->name, strlen(it->name)) == 0) error += strlen(it->name) + 2; /* "name: what happened" */
    stop(3, "%s: %s: %s: %s", it->name, call, STATUS[status], *error ? error : "the FMU says no more; --log may");
}

static void show(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...) {
    va_list values;
    (void)environment, (void)category;
    if (quiet) return;
    va_start(values, message);
    fprintf(stderr, "%s (%s): ", instance, STATUS[status]);
    vfprintf(stderr, message, values);
    fprintf(stderr, "\n");
    va_end(values);
}

static void load(Instance *it, int number) {
    char path[PATH_MAX + 2 * LENGTH], model[LENGTH], address[3 * PATH_MAX] = "file://", guid[LENGTH];
    size_t size;
    snprintf(path, sizeof path, "%s/modelDescription.xml", it->folder);
    it->description = read_file(path, &size);
    const char *root = strstr(it->description, "<fmiModelDescription"), *simulation = strstr(it->description, "<CoSimulation");
    if (root == NULL || simulation == NULL || !attribute(root, "guid", guid, LENGTH) ||
        !attribute(simulation, "modelIdentifier", model, LENGTH))
        stop(1, "%s: no FMI 2.0 co-simulation FMU", path);
    snprintf(it->name, sizeof it->name, "%s_%d", model, number);
    snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", it->folder, model);
    it->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (it->library == NULL) stop(1, "%s", dlerror());
#define RESOLVE(call)                                             \
    *(void **)(&it->call) = dlsym(it->library, "fmi2" #call);     \
    if (it->call == NULL) stop(1, "%s has no fmi2" #call, path);
    FUNCTIONS(RESOLVE)

    /* resources as a URI: what is not plain is written as %XX */
    char *to = address + strlen(address);
    snprintf(path, sizeof path, "%s/resources", it->folder);
    const char *plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/";
    for (const char *from = path; *from; from++)
        to += sprintf(to, strchr(plain, *from) ? "%c" : "%%%02X", (unsigned char)*from);
    it->callbacks = (fmi2CallbackFunctions){show, calloc, free, NULL, NULL};
    quiet = 0; /* why there is no instance must be seen */
    it->component =
        it->Instantiate(it->name, fmi2CoSimulation, guid, address, &it->callbacks, fmi2False, logging ? fmi2True : fmi2False);
    if (it->component == NULL) stop(3, "%s: fmi2Instantiate gave no instance; the FMU said why", it->name);
    quiet = !logging;

    const char *at = it->description;
    Variable variable;
    char causality[LENGTH];
    while (next_variable(&at, &variable, causality))
        if (strcmp(causality, "output") == 0 && variable.kind == 'R' && it->n_outputs < NAMES)
            it->outputs[it->n_outputs++] = variable;
    for (int i = 1; i < it->table.columns; i++) {
        if (!find(it, it->table.names[i], &variable) || variable.kind != 'R')
            stop(1, "%s has no Real input %s", it->name, it->table.names[i]);
        it->inputs[i - 1] = variable.reference;
    }
}

static void set_parameter(Instance *it, char *setting) {
    Variable variable;
    char *value = strchr(setting, '='), *end = "";
    *value++ = '\0';
    if (!find(it, setting, &variable)) stop(1, "%s has no variable %s", it->name, setting);
    fmi2Status status = fmi2OK;
    if (variable.kind == 'R') {
        fmi2Real number = strtod(value, &end);
        status = it->SetReal(it->component, &variable.reference, 1, &number);
    } else if (variable.kind == 'I') {
        fmi2Integer number = (fmi2Integer)strtol(value, &end, 10);
        status = it->SetInteger(it->component, &variable.reference, 1, &number);
    } else if (variable.kind == 'B') {
        fmi2Boolean truth = strcmp(value, "true") == 0 ? fmi2True : fmi2False;
        if (!truth && strcmp(value, "false") != 0) end = value;
        status = it->SetBoolean(it->component, &variable.reference, 1, &truth);
    } else {
        fmi2String text = value;
        status = it->SetString(it->component, &variable.reference, 1, &text);
    }
    if (*end != '\0' || (*value == '\0' && variable.kind != 'S')) stop(1, "%s=%s: give a number, or true or false of a Boolean", setting, value);
    check(it, "fmi2Set", status);
}

static void set_inputs(Instance *it, int row) {
    const double *values = it->table.values + row * it->table.columns + 1;
    check(it, "fmi2SetReal", it->SetReal(it->component, it->inputs, (size_t)(it->table.columns - 1), values));
}

static void print(Instance *it, int row) {
    printf("%s %.17g", it->name, it->table.values[row * it->table.columns]);
    for (int i = 0; i < it->n_outputs; i++) {
        fmi2Real value;
        check(it, "fmi2GetReal", it->GetReal(it->component, &it->outputs[i].reference, 1, &value));
        printf(" %.17g", value);
    }
    printf("\n");
}

/* Step all instances in turn from row `first` to row `last`; nothing connects them here. */
static void march(Instance *instances, int count, int first, int last, int shown) {
    for (int row = first; row < last; row++)
        for (int i = 0; i < count; i++) {
            Instance *it = &instances[i];
            if (row + 1 >= it->table.rows) continue;
            const double time = it->table.values[row * it->table.columns];
            const double next = it->table.values[(row + 1) * it->table.columns];
            set_inputs(it, row + 1);
            check(it, "fmi2DoStep", it->DoStep(it->component, time, next - time, fmi2False));
            if (shown) print(it, row + 1);
        }
}

int main(int argc, char **argv) {
    static Instance instances[MOST];
    const char *how = "exit", *file = NULL;
    int count = 0, rollback = -1, save = -1, resume = -1, at = 1, last = 0;
    for (; at < argc && strncmp(argv[at], "--", 2) == 0; at++) {
        int left = argc - at - 1;
        if (strcmp(argv[at], "--log") == 0) logging = 1;
        else if (strcmp(argv[at], "--end") == 0 && left > 0) how = argv[++at];
        else if (strcmp(argv[at], "--rollback") == 0 && left > 0) rollback = atoi(argv[++at]);
        else if (strcmp(argv[at], "--save") == 0 && left > 1) save = atoi(argv[++at]), file = argv[++at];
        else if (strcmp(argv[at], "--resume") == 0 && left > 1) resume = atoi(argv[++at]), file = argv[++at];
        else stop(1, "%s: no such option, or its value is missing; the head of host.c tells how to use it", argv[at]);
    }
    while (at + 1 < argc) {
        if (count == MOST) stop(1, "at most %d FMUs", MOST);
        Instance *it = &instances[count++];
        if (realpath(argv[at], it->folder) == NULL) stop(1, "there is no folder %s; give an unzipped FMU", argv[at]);
        read_table(&it->table, argv[at + 1]);
        last = it->table.rows - 1 > last ? it->table.rows - 1 : last;
        it->settings = argv + (at += 2);
        for (; at < argc && strcmp(argv[at], "+") != 0; at++, it->n_settings++)
            if (strchr(argv[at], '=') == NULL) stop(1, "%s is no NAME=VALUE", argv[at]);
        at++;
    }
    if (count == 0) stop(1, "use: host [OPTIONS] FMU TABLE [NAME=VALUE ...] [+ FMU TABLE [NAME=VALUE ...]] ...");

    for (int i = 0; i < count; i++) {
        Instance *it = &instances[i];
        load(it, i + 1);
        printf("# %s time", it->name);
        for (int k = 0; k < it->n_outputs; k++) printf(" %s", it->outputs[k].name);
        printf("\n");
        for (int k = 0; k < it->n_settings; k++) set_parameter(it, it->settings[k]);
        check(it, "fmi2SetupExperiment", it->SetupExperiment(it->component, fmi2False, 0.0, it->table.values[0], fmi2False, 0.0));
        set_inputs(it, 0);
        check(it, "fmi2EnterInitializationMode", it->EnterInitializationMode(it->component));
        check(it, "fmi2ExitInitializationMode", it->ExitInitializationMode(it->component));
        if (resume < 0) print(it, 0);
    }

    Instance *one = &instances[0];
    fmi2FMUstate state = NULL;
    int row = 0;
    if (resume >= 0) {
        size_t size;
        char *bytes = read_file(file, &size);
        check(one, "fmi2DeSerializeFMUstate", one->DeSerializeFMUstate(one->component, bytes, size, &state));
        check(one, "fmi2SetFMUstate", one->SetFMUstate(one->component, state));
        row = resume;
    } else if (save >= 0 || rollback >= 0) {
        row = save >= 0 ? save : rollback;
        march(instances, count, 0, row, 1);
        check(one, "fmi2GetFMUstate", one->GetFMUstate(one->component, &state));
        if (save >= 0) {
            size_t size;
            check(one, "fmi2SerializedFMUstateSize", one->SerializedFMUstateSize(one->component, state, &size));
            char *bytes = malloc(size);
            FILE *out = fopen(file, "wb");
            if (bytes == NULL || out == NULL) stop(1, "%s cannot be written", file);
            check(one, "fmi2SerializeFMUstate", one->SerializeFMUstate(one->component, state, bytes, size));
            if (fwrite(bytes, 1, size, out) != size || fclose(out) != 0) stop(1, "%s cannot be written", file);
            free(bytes);
        } else {
            march(one, 1, row, last, 0); /* to be forgotten */
            check(one, "fmi2SetFMUstate", one->SetFMUstate(one->component, state));
        }
    }
    if (state != NULL) check(one, "fmi2FreeFMUstate", one->FreeFMUstate(one->component, &state));
    march(instances, count, row, last, 1);
    finish(instances, count, how, 0);
}
