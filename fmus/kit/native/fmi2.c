/* The shared library of an FMU written in Python: FMI 2.0 co-simulation for any host, whether it is a Python program or not.

It knows no header and no library of Python. At the first fmi2Instantiate it finds a Python (`choose` below says which), takes the
functions of its C API by name, imports the module that resources/slavemodule.txt names, and makes an instance of the class SLAVE
in it, a subclass of pythonfmu's Fmi2Slave. What the methods of that class return:

    set_*, setup_experiment, enter_…, exit_…, terminate, do_step, _set_fmu_state
                a status as an integer; None and True are fmi2OK, False is fmi2Discard
    get_*       as many values as references: fmi2OK; one more: that is the status
    _get_fmu_state, _fmu_state_from_bytes
                anything; None: there is no state, fmi2Error

Instances and states are known by handles that are addresses of nothing and are never given out twice, so a host may hand in what
it has freed, or anything else, and gets fmi2Error. All of this file's data are used with the GIL held, which is their lock.

Python is never ended, and this library stays loaded (-z nodelete): a host may exit, fork, and unload it as it likes. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <locale.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <wchar.h>

#define EXPORT __attribute__((visibility("default")))
#define LOCAL static
#define TEXT 4096          /* longest message of our own */
#define PATIENCE_MS 60000  /* for a Python to say where its library is */
#define OLDEST 11          /* Python 3.11 */

/* ---- FMI 2.0, as its standard gives the types (default platform) */

typedef void *Component;
typedef void *State;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef void (*Logger)(void *environment, const char *instance, Status status, const char *category, const char *message, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, Status);
    void *environment;
} Callbacks;
enum { CO_SIMULATION = 1 };
enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED };

/* ---- Python's C API, the part that is used */

typedef void PyObject;
typedef ptrdiff_t Py_ssize_t;
enum { GIL_LOCKED = 0, GIL_UNLOCKED = 1 };

#define API(X) \
    X(int, Py_IsInitialized, (void)) \
    X(const char *, Py_GetVersion, (void)) \
    X(void, Py_InitializeEx, (int)) \
    X(void, Py_IncRef, (PyObject *)) \
    X(void, Py_DecRef, (PyObject *)) \
    X(int, PyGILState_Ensure, (void)) \
    X(void, PyGILState_Release, (int)) \
    X(int, PyGILState_Check, (void)) \
    X(void *, PyGILState_GetThisThreadState, (void)) \
    X(void *, PyEval_SaveThread, (void)) \
    X(void, PyOS_BeforeFork, (void)) \
    X(void, PyOS_AfterFork_Parent, (void)) \
    X(void, PyOS_AfterFork_Child, (void)) \
    X(PyObject *, PyErr_Occurred, (void)) \
    X(void, PyErr_Clear, (void)) \
    X(void, PyErr_Fetch, (PyObject **, PyObject **, PyObject **)) \
    X(void, PyErr_NormalizeException, (PyObject **, PyObject **, PyObject **)) \
    X(PyObject *, PyImport_ImportModule, (const char *)) \
    X(PyObject *, PySys_GetObject, (const char *)) \
    X(PyObject *, PyObject_GetAttrString, (PyObject *, const char *)) \
    X(PyObject *, PyObject_Call, (PyObject *, PyObject *, PyObject *)) \
    X(PyObject *, PyObject_CallNoArgs, (PyObject *)) \
    X(PyObject *, PyObject_Vectorcall, (PyObject *, PyObject *const *, size_t, PyObject *)) \
    X(PyObject *, PyObject_Str, (PyObject *)) \
    X(int, PyObject_IsTrue, (PyObject *)) \
    X(Py_ssize_t, PyObject_Size, (PyObject *)) \
    X(PyObject *, PySequence_Tuple, (PyObject *)) \
    X(PyObject *, PyTuple_New, (Py_ssize_t)) \
    X(Py_ssize_t, PyTuple_Size, (PyObject *)) \
    X(int, PyTuple_SetItem, (PyObject *, Py_ssize_t, PyObject *)) \
    X(PyObject *, PyTuple_GetItem, (PyObject *, Py_ssize_t)) \
    X(Py_ssize_t, PyList_Size, (PyObject *)) \
    X(PyObject *, PyList_GetItem, (PyObject *, Py_ssize_t)) \
    X(int, PyList_Insert, (PyObject *, Py_ssize_t, PyObject *)) \
    X(int, PyList_SetSlice, (PyObject *, Py_ssize_t, Py_ssize_t, PyObject *)) \
    X(PyObject *, PyDict_New, (void)) \
    X(PyObject *, PyDict_GetItemString, (PyObject *, const char *)) \
    X(int, PyDict_SetItemString, (PyObject *, const char *, PyObject *)) \
    X(PyObject *, PyBool_FromLong, (long)) \
    X(PyObject *, PyLong_FromLong, (long)) \
    X(PyObject *, PyLong_FromUnsignedLong, (unsigned long)) \
    X(long, PyLong_AsLong, (PyObject *)) \
    X(PyObject *, PyFloat_FromDouble, (double)) \
    X(double, PyFloat_AsDouble, (PyObject *)) \
    X(PyObject *, PyUnicode_DecodeUTF8, (const char *, Py_ssize_t, const char *)) \
    X(PyObject *, PyUnicode_DecodeFSDefault, (const char *)) \
    X(const char *, PyUnicode_AsUTF8AndSize, (PyObject *, Py_ssize_t *)) \
    X(PyObject *, PyBytes_FromStringAndSize, (const char *, Py_ssize_t)) \
    X(int, PyBytes_AsStringAndSize, (PyObject *, char **, Py_ssize_t *))
#define DECLARE(type, name, arguments) type(*name) arguments;
LOCAL struct {
    API(DECLARE)
    int (*finalizing)(void); /* Py_IsFinalizing, or its older name, or NULL */
    PyObject *none, *true_, *false_;
    int ready;
} py;

/* ---- what this library holds */

enum { REAL, INTEGER, BOOLEAN, STRING, TYPES };
enum { SETUP, ENTER, LEAVE, STEP, TERMINATE, SAVE, RESTORE, TO_BYTES, FROM_BYTES, COMPLAIN, GET, SET = GET + TYPES,
       METHODS = SET + TYPES };
LOCAL const char *const NAMES[METHODS] = {
    "setup_experiment", "enter_initialization_mode", "exit_initialization_mode", "do_step", "terminate", "_get_fmu_state",
    "_set_fmu_state", "_fmu_state_to_bytes", "_fmu_state_from_bytes", "complain", "get_real", "get_integer", "get_boolean",
    "get_string", "set_real", "set_integer", "set_boolean", "set_string"};

typedef struct Entry { /* common head of what has a handle */
    uintptr_t handle;
    struct Entry *next;
    int is_state;
} Entry;

typedef struct {
    Entry entry;
    PyObject *slave, *make, *arguments; /* the object; its class and keyword arguments, for a reset */
    PyObject *methods[METHODS], *queue;  /* bound methods; the list of its messages */
    Py_ssize_t variables;                /* how many it has */
    struct { Reference *numbers; size_t count; PyObject *tuple; } last[2 * TYPES]; /* references of the last call of each kind */
    PyObject *strings;                   /* what the last fmi2GetString pointed into */
    char *name;
    Logger logger;
    void *environment;
    char **categories;
    size_t category_count;
    int logging, told; /* told: without logging, the first sentence of a failure is passed on, and no more */
    int busy, freed;   /* a call is under way; the instance was freed in the meantime */
} Instance;

typedef struct {
    Entry entry;
    PyObject *state;
} Kept;

typedef struct { /* one message on its way to the host's logger */
    Status status;
    char *category, *text;
} Message;

enum { BUCKETS = 4096 };
LOCAL Entry *buckets[BUCKETS];
LOCAL uint32_t handles; /* given out so far */
LOCAL pthread_key_t thread_key;

/* ---- handles: bit 63 set and bit 62 clear is the address of nothing on a 64-bit machine; the page of this library's data tells
   it from other FMUs' libraries, the low half counts */

LOCAL uintptr_t handle_base(void) {
    return (uintptr_t)1 << 63 | (((uintptr_t)&handles >> 12) & 0x3fffffff) << 32;
}

LOCAL int is_handle(uintptr_t value) { return value >> 62 == 2; }

LOCAL Entry *find(const void *handle, int is_state) {
    uintptr_t value = (uintptr_t)handle;
    for (Entry *at = buckets[value % BUCKETS]; at != NULL; at = at->next)
        if (at->handle == value) return at->is_state == is_state ? at : NULL;
    return NULL;
}

LOCAL void *add(Entry *entry, int is_state) {
    entry->is_state = is_state;
    do entry->handle = handle_base() | ++handles;
    while (handles == 0 || find((void *)entry->handle, 0) || find((void *)entry->handle, 1));
    entry->next = buckets[entry->handle % BUCKETS];
    buckets[entry->handle % BUCKETS] = entry;
    return (void *)entry->handle;
}

LOCAL void take_out(Entry *entry) {
    Entry **at = &buckets[entry->handle % BUCKETS];
    while (*at != entry) at = &(*at)->next;
    *at = entry->next;
}

/* ---- the GIL: a thread that Python does not know gets a state at its first call and keeps it until it ends */

LOCAL int python_runs(void) {
    return __atomic_load_n(&py.ready, __ATOMIC_ACQUIRE) && py.Py_IsInitialized() && !(py.finalizing && py.finalizing());
}

LOCAL int enter(int *gil) {
    if (!python_runs()) return 0;
    if (py.PyGILState_GetThisThreadState() == NULL) {
        py.PyGILState_Ensure();
        py.PyEval_SaveThread(); /* its count stays one, so the state stays */
        pthread_setspecific(thread_key, &thread_key);
    }
    *gil = py.PyGILState_Ensure();
    return 1;
}

LOCAL void leave(int gil) { py.PyGILState_Release(gil); }

LOCAL void thread_ends(void *unused) {
    (void)unused;
    if (!python_runs() || py.PyGILState_GetThisThreadState() == NULL) return;
    py.PyGILState_Ensure();
    py.PyGILState_Release(GIL_LOCKED);   /* back to one */
    py.PyGILState_Release(GIL_UNLOCKED); /* none: the state goes, and the GIL with it */
}

/* A fork by a host that knows nothing of Python: the child's only thread has the GIL and whole data. A fork by Python itself,
   or by another FMU's library that was asked first, finds the GIL held by this thread and is left alone. */
LOCAL __thread int forking, fork_gil;
LOCAL int watching; /* forks, from the first instance on: what is registered last is asked first, and a library for linear algebra
                       that the instance brought ends its threads at a fork, for which another thread's call would wait */

LOCAL void before_fork(void) {
    forking = 0;
    if (!python_runs() || py.PyGILState_Check() || !enter(&fork_gil)) return;
    py.PyOS_BeforeFork();
    forking = 1;
}

LOCAL void after_fork_in_parent(void) {
    if (!forking) return;
    forking = 0;
    py.PyOS_AfterFork_Parent();
    leave(fork_gil);
}

LOCAL void after_fork_in_child(void) {
    if (!forking) return;
    forking = 0;
    py.PyOS_AfterFork_Child();
    leave(fork_gil);
}

/* ---- texts */

LOCAL char *copy(const char *text, size_t length) {
    char *made = malloc(length + 1);
    if (made == NULL) return NULL;
    memcpy(made, text, length);
    made[length] = '\0';
    return made;
}

/* Hosts take a message for a printf format: what is a percent sign to us is written twice. */
LOCAL char *escaped(const char *text) {
    char *made = malloc(2 * strlen(text) + 1), *to = made;
    if (made == NULL) return NULL;
    for (; *text; *to++ = *text++)
        if (*text == '%') *to++ = '%';
    *to = '\0';
    return made;
}

__attribute__((format(printf, 2, 3))) LOCAL void write_text(char text[TEXT], const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsnprintf(text, TEXT, format, values);
    va_end(values);
}

/* The whole of a small file without the white space at its end; 0 where there is none. */
LOCAL int read_small(const char *folder, const char *name, char *text, size_t size) {
    char path[PATH_MAX];
    if ((size_t)snprintf(path, sizeof path, "%s/%s", folder, name) >= sizeof path) return 0;
    FILE *file = fopen(path, "rbe");
    if (file == NULL) return 0;
    size_t length = fread(text, 1, size - 1, file);
    fclose(file);
    while (length > 0 && strchr(" \t\r\n", text[length - 1])) length--;
    text[length] = '\0';
    return length > 0;
}

/* The pending Python error in one line, which is then gone. */
LOCAL void error_text(char text[TEXT]) {
    PyObject *type = NULL, *value = NULL, *trace = NULL, *said = NULL;
    const char *words = NULL;
    py.PyErr_Fetch(&type, &value, &trace);
    py.PyErr_NormalizeException(&type, &value, &trace);
    if (value != NULL && (said = py.PyObject_Str(value)) != NULL) words = py.PyUnicode_AsUTF8AndSize(said, NULL);
    write_text(text, "%s", words && *words ? words : "an error without a text");
    for (char *at = text; *at; at++)
        if (*at == '\n' || *at == '\r') *at = ' ';
    py.Py_DecRef(said);
    py.Py_DecRef(type);
    py.Py_DecRef(value);
    py.Py_DecRef(trace);
    py.PyErr_Clear();
}

/* ---- where the resources are */

LOCAL int hex(char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

LOCAL int has_slave(const char *folder) {
    char path[PATH_MAX];
    return (size_t)snprintf(path, sizeof path, "%s/slavemodule.txt", folder) < sizeof path && access(path, R_OK) == 0;
}

/* The folder that a URI names (file:///…, file:/…, file://host/…, or a path), decoded, or as it is where a tool encodes none. */
LOCAL int folder_of(const char *uri, char folder[PATH_MAX]) {
    const char *at = uri;
    if (strncmp(at, "file:", 5) == 0) {
        at += 5;
        if (strncmp(at, "//", 2) == 0) {
            at += 2;
            at += strcspn(at, "/"); /* an empty host, or localhost */
        }
    }
    for (int decode = 1; decode >= 0; decode--) {
        size_t length = 0;
        for (const char *from = at; *from && length + 1 < PATH_MAX; length++) {
            int coded = decode && *from == '%' && hex(from[1]) >= 0 && hex(from[2]) >= 0;
            folder[length] = coded ? (char)(16 * hex(from[1]) + hex(from[2])) : *from;
            from += coded ? 3 : 1;
        }
        folder[length] = '\0';
        while (length > 1 && folder[length - 1] == '/') folder[--length] = '\0';
        if (has_slave(folder)) return 1;
    }
    return 0;
}

LOCAL int find_resources(const char *uri, char folder[PATH_MAX]) {
    char absolute[PATH_MAX];
    Dl_info info;
    int found = uri != NULL && folder_of(uri, folder);
    if (!found && dladdr(&handles, &info) != 0 && info.dli_fname != NULL) {
        /* <unzipped>/binaries/linux64/<name>.so */
        if (realpath(info.dli_fname, absolute) == NULL) return 0;
        for (int up = 0; up < 3; up++) {
            char *slash = strrchr(absolute, '/');
            if (slash == NULL) return 0;
            *slash = '\0';
        }
        found = (size_t)snprintf(folder, PATH_MAX, "%s/resources", absolute) < PATH_MAX && has_slave(folder);
    }
    if (found && folder[0] != '/' && realpath(folder, absolute) != NULL) strcpy(folder, absolute);
    return found;
}

/* ---- which Python */

typedef struct { /* what find_python.py prints, a line each */
    char version[32], executable[PATH_MAX], library[PATH_MAX], problem[TEXT];
} Found;

/* Run `python` (a path, or a name to be looked up on PATH) with find_python.py; what it said, or why it said nothing. */
LOCAL int asked(const char *python, const char *resources, Found *found) {
    char script[PATH_MAX], answer[3 * PATH_MAX + TEXT];
    int ends[2], status = 0;
    pid_t child;
    posix_spawn_file_actions_t actions;
    memset(found, 0, sizeof *found);
    if ((size_t)snprintf(script, sizeof script, "%s/find_python.py", resources) >= sizeof script || pipe2(ends, O_CLOEXEC) != 0) {
        write_text(found->problem, "it cannot be asked");
        return 0;
    }
    char *words[] = {(char *)python, "-E", script, NULL};
    extern char **environ;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    int failed = posix_spawnp(&child, python, &actions, NULL, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    size_t length = 0;
    if (!failed) {
        struct pollfd wait = {.fd = ends[0], .events = POLLIN};
        for (;;) {
            int ready = poll(&wait, 1, PATIENCE_MS);
            if (ready < 0 && errno == EINTR) continue;
            ssize_t got = ready > 0 ? read(ends[0], answer + length, sizeof answer - 1 - length) : 0;
            if (ready == 0) kill(child, SIGKILL);
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) break;
            length += (size_t)got;
        }
        while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    }
    close(ends[0]);
    answer[length] = '\0';
    struct { char *to; size_t size; } fields[] = {{found->version, sizeof found->version},
                                                  {found->executable, sizeof found->executable},
                                                  {found->library, sizeof found->library},
                                                  {found->problem, sizeof found->problem}};
    char *at = answer;
    for (int i = 0; i < 4; i++) {
        char *end = strchr(at, '\n');
        if (end == NULL) {
            snprintf(found->problem, sizeof found->problem, failed == ENOENT ? "there is no such program" : "it does not run");
            return 0;
        }
        *end = '\0';
        snprintf(fields[i].to, fields[i].size, "%s", at);
        at = end + 1;
    }
    return found->problem[0] == '\0';
}

/* The same; `version` is that of a library which is in the process already, or NULL. */
LOCAL int ask(const char *python, const char *resources, const char *version, Found *found) {
    if (!asked(python, resources, found)) return 0;
    size_t length = strlen(found->version);
    if (version == NULL || (strncmp(version, found->version, length) == 0 && version[length] == '.')) return 1;
    write_text(found->problem, "it is Python %s, and this process holds the library of %.10s", found->version, version);
    return 0;
}

LOCAL int choose(const char *resources, const char *version, Found *found, char why[TEXT]) {
    const char *remedy =
        "Remedy: set AEROSLOSH_PYTHON to a python3 (3.11 or newer, with a shared libpython) that has the packages of";
    const char *own = getenv("AEROSLOSH_PYTHON");
    char line[PATH_MAX], installed[TEXT] = "";
    if (own != NULL && *own) {
        if (ask(own, resources, version, found)) return 1;
        write_text(why, "AEROSLOSH_PYTHON = %s: %s. %s %s/requirements.txt", own, found->problem, remedy, resources);
        return 0;
    }
    if (read_small(resources, "python.txt", line, sizeof line) && access(line, X_OK) == 0) {
        if (ask(line, resources, version, found)) return 1;
        write_text(installed, "; nor is %.1000s of resources/python.txt: %.1000s", line, found->problem);
    }
    if (ask("python3", resources, version, found)) return 1;
    write_text(why, "no Python for this FMU: python3 on PATH%s%.1000s is none: %.1000s%.1500s. %s %s/requirements.txt",
               found->executable[0] ? ", " : "", found->executable, found->problem, installed, remedy, resources);
    return 0;
}

/* ---- Python into the process */

LOCAL int note_libpython(struct dl_phdr_info *info, size_t size, void *data) {
    (void)size;
    const char *base = strrchr(info->dlpi_name, '/');
    base = base ? base + 1 : info->dlpi_name;
    if (strncmp(base, "libpython3.", 11) != 0 || strlen(info->dlpi_name) >= PATH_MAX) return 0;
    strcpy(data, info->dlpi_name);
    return 1;
}

LOCAL int take_api(char why[TEXT]) {
    memset(&py, 0, sizeof py);
#define TAKE(type, name, arguments) \
    if ((*(void **)&py.name = dlsym(RTLD_DEFAULT, #name)) == NULL) { \
        write_text(why, "the Python in this process has no " #name ": it is no Python 3.%d or newer", OLDEST); \
        return 0; \
    }
    API(TAKE)
    *(void **)&py.finalizing = dlsym(RTLD_DEFAULT, "Py_IsFinalizing");
    if (py.finalizing == NULL) *(void **)&py.finalizing = dlsym(RTLD_DEFAULT, "_Py_IsFinalizing");
    py.none = dlsym(RTLD_DEFAULT, "_Py_NoneStruct");
    py.true_ = dlsym(RTLD_DEFAULT, "_Py_TrueStruct");
    py.false_ = dlsym(RTLD_DEFAULT, "_Py_FalseStruct");
    if (py.none == NULL || py.true_ == NULL || py.false_ == NULL) {
        write_text(why, "the Python in this process does not show None, True and False");
        return 0;
    }
    return 1;
}

/* UTF-8 as Python decodes the names of files: a byte that is none of it becomes half of a surrogate pair. */
LOCAL wchar_t *wide(const char *text) {
    wchar_t *made = malloc((strlen(text) + 1) * sizeof(wchar_t)), *to = made;
    if (made == NULL) return NULL;
    for (const unsigned char *at = (const unsigned char *)text; *at;) {
        int more = *at < 0x80 ? 0 : *at < 0xc2 ? -1 : *at < 0xe0 ? 1 : *at < 0xf0 ? 2 : *at < 0xf5 ? 3 : -1;
        uint32_t point = more == 0 ? *at : more > 0 ? *at & (0x3fu >> more) : 0;
        int i = 1;
        for (; i <= more && (at[i] & 0xc0) == 0x80; i++) point = point << 6 | (at[i] & 0x3fu);
        if (more < 0 || i <= more) {
            *to++ = (wchar_t)(0xdc00 + *at++);
        } else {
            *to++ = (wchar_t)point;
            at += more + 1;
        }
    }
    *to = L'\0';
    return made;
}

/* No signal handlers (Ctrl-C is the host's), no PYTHON* variables (a host's environment is about other things), file names and
   texts in UTF-8 whatever the locale, and the host's own locale stays. */
LOCAL int initialize(const char *executable, char why[TEXT]) {
    char *locale = setlocale(LC_CTYPE, NULL), *before = locale ? copy(locale, strlen(locale)) : NULL;
    void *(*create)(void), (*discard)(void *);
    int (*set_text)(void *, const char *, const char *), (*set_number)(void *, const char *, int64_t), (*start)(void *);
    int (*get_error)(void *, const char **);
    int done = 0;
    *(void **)&create = dlsym(RTLD_DEFAULT, "PyInitConfig_Create");
    if (create != NULL) { /* Python 3.14 and newer */
        *(void **)&discard = dlsym(RTLD_DEFAULT, "PyInitConfig_Free");
        *(void **)&set_text = dlsym(RTLD_DEFAULT, "PyInitConfig_SetStr");
        *(void **)&set_number = dlsym(RTLD_DEFAULT, "PyInitConfig_SetInt");
        *(void **)&start = dlsym(RTLD_DEFAULT, "Py_InitializeFromInitConfig");
        *(void **)&get_error = dlsym(RTLD_DEFAULT, "PyInitConfig_GetError");
        void *config = discard && set_text && set_number && start && get_error ? create() : NULL;
        const char *said = NULL;
        if (config != NULL) {
            done = set_number(config, "utf8_mode", 1) == 0 && set_text(config, "program_name", executable) == 0 &&
                   set_number(config, "user_site_directory", 1) == 0 && start(config) == 0;
            if (!done) get_error(config, &said);
            if (!done) write_text(why, "Python does not start: %s", said ? said : "it says no more");
            discard(config);
        } else {
            write_text(why, "Python does not start: its PyInitConfig is not whole");
        }
    } else {
        void (*set_name)(const wchar_t *);
        int *ignore = dlsym(RTLD_DEFAULT, "Py_IgnoreEnvironmentFlag"), *utf8 = dlsym(RTLD_DEFAULT, "Py_UTF8Mode");
        static wchar_t *name; /* Python may go on using it */
        name = wide(executable);
        *(void **)&set_name = dlsym(RTLD_DEFAULT, "Py_SetProgramName");
        if (set_name != NULL && ignore != NULL && utf8 != NULL && name != NULL) {
            *ignore = *utf8 = 1;
            set_name(name);
            py.Py_InitializeEx(0);
            done = 1;
        } else {
            write_text(why, "Python does not start: it cannot be told its own place");
        }
    }
    if (before != NULL) setlocale(LC_CTYPE, before);
    free(before);
    return done;
}

LOCAL int start_python(const char *resources, char why[TEXT]) {
    Found found;
    char loaded[PATH_MAX] = "";
    int (*runs)(void);
    *(void **)&runs = dlsym(RTLD_DEFAULT, "Py_IsInitialized");
    if (runs == NULL && dl_iterate_phdr(note_libpython, loaded) && dlopen(loaded, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD) != NULL)
        *(void **)&runs = dlsym(RTLD_DEFAULT, "Py_IsInitialized"); /* the host had loaded it for itself alone */
    if (runs != NULL && runs()) {
        if (!take_api(why)) return 0;
    } else {
        const char *(*version)(void) = NULL;
        if (runs != NULL) *(void **)&version = dlsym(RTLD_DEFAULT, "Py_GetVersion");
        if (!choose(resources, version ? version() : NULL, &found, why)) return 0;
        if (runs == NULL && dlopen(found.library, RTLD_NOW | RTLD_GLOBAL) == NULL) {
            const char *said = dlerror();
            write_text(why, "%s of %s cannot be loaded: %s", found.library, found.executable, said ? said : "no more is said");
            return 0;
        }
        if (!take_api(why)) return 0;
        struct sigaction interrupt; /* Python's module `signal` takes SIGINT when it is imported, whatever it was told */
        int kept = sigaction(SIGINT, NULL, &interrupt) == 0;
        if (!initialize(found.executable, why)) return 0;
        py.Py_DecRef(py.PyImport_ImportModule("signal"));
        py.PyErr_Clear();
        if (kept) sigaction(SIGINT, &interrupt, NULL);
        py.PyEval_SaveThread();
    }
    if (atoi(py.Py_GetVersion() + 2) < OLDEST && py.Py_GetVersion()[0] == '3') {
        write_text(why, "the Python in this process is %.20s; this FMU needs 3.%d or newer", py.Py_GetVersion(), OLDEST);
        return 0;
    }
    if (pthread_key_create(&thread_key, thread_ends) != 0) {
        write_text(why, "this process has no thread keys left");
        return 0;
    }
    __atomic_store_n(&py.ready, 1, __ATOMIC_RELEASE);
    return 1;
}

/* Several FMUs' libraries may be asked for their first instance at the same time. What they share is the C library's lock of
   stderr, which one thread may take several times. */
LOCAL int python(const char *resources, char why[TEXT]) {
    if (__atomic_load_n(&py.ready, __ATOMIC_ACQUIRE)) {
        if (python_runs()) return 1;
        write_text(why, "the Python of this process has ended");
        return 0;
    }
    flockfile(stderr);
    int done = __atomic_load_n(&py.ready, __ATOMIC_ACQUIRE) || start_python(resources, why);
    funlockfile(stderr);
    return done;
}

/* ---- messages to the host */

/* Without logging the first sentence of a failure is all that is told; with it, what belongs to the categories asked for. */
LOCAL int wanted(Instance *one, Status status, const char *category) {
    if (one->logger == NULL) return 0;
    if (!one->logging) {
        if (status < DISCARD || one->told) return 0;
        return one->told = 1;
    }
    for (size_t i = 0; i < one->category_count; i++)
        if (strcmp(one->categories[i], category) == 0 || strcmp(one->categories[i], "logAll") == 0) return 1;
    return one->category_count == 0;
}

LOCAL char *attribute_text(PyObject *object, const char *name) {
    PyObject *value = py.PyObject_GetAttrString(object, name);
    Py_ssize_t length = 0;
    const char *text = value ? py.PyUnicode_AsUTF8AndSize(value, &length) : NULL;
    char *made = text ? copy(text, (size_t)length) : NULL;
    py.Py_DecRef(value);
    py.PyErr_Clear();
    return made;
}

LOCAL Status attribute_status(PyObject *object) {
    PyObject *status = py.PyObject_GetAttrString(object, "status"), *number = NULL;
    if (status != NULL && (number = py.PyObject_GetAttrString(status, "value")) == NULL) {
        py.PyErr_Clear();
        py.Py_IncRef(number = status);
    }
    long value = number ? py.PyLong_AsLong(number) : ERROR;
    py.Py_DecRef(number);
    py.Py_DecRef(status);
    py.PyErr_Clear();
    return value >= OK && value <= FATAL ? (Status)value : ERROR;
}

/* Take what is in the slave's queue; NULL for nothing. The last one has no text. */
LOCAL Message *messages(Instance *one) {
    Py_ssize_t count = one->queue ? py.PyList_Size(one->queue) : 0, kept = 0;
    if (count <= 0) return NULL;
    Message *made = calloc((size_t)count + 1, sizeof *made);
    for (Py_ssize_t i = 0; made != NULL && i < count; i++) {
        PyObject *message = py.PyList_GetItem(one->queue, i);
        Message m = {attribute_status(message), attribute_text(message, "category"), attribute_text(message, "msg")};
        if (m.text != NULL && m.category != NULL && wanted(one, m.status, m.category)) {
            if (!one->logging) m.text[strcspn(m.text, "\n")] = '\0'; /* a traceback is for who looks for it */
            made[kept++] = m;
        } else {
            free(m.category);
            free(m.text);
        }
    }
    py.PyList_SetSlice(one->queue, 0, count, NULL);
    py.PyErr_Clear();
    return made;
}

/* The reason why there is no instance: always told. */
LOCAL Component no_instance(const Callbacks *callbacks, int logging, const char *name, const char *why) {
    char text[TEXT + 256];
    snprintf(text, sizeof text, "%s: %s", name ? name : "(no name)", why);
    char *said = escaped(text);
    if (callbacks != NULL && callbacks->logger != NULL && said != NULL)
        callbacks->logger(callbacks->environment, name ? name : "", ERROR, "logStatusError", said);
    if (callbacks == NULL || callbacks->logger == NULL || !logging) fprintf(stderr, "%s\n", text);
    free(said);
    return NULL;
}

/* ---- a call: begin, the work, end */

LOCAL PyObject *call(PyObject *method, size_t count, PyObject *a, PyObject *b, PyObject *c) {
    PyObject *arguments[] = {a, b, c}, *result = NULL;
    int whole = method != NULL;
    for (size_t i = 0; i < count; i++) whole &= arguments[i] != NULL;
    if (whole) result = py.PyObject_Vectorcall(method, arguments, count, NULL);
    for (size_t i = 0; i < count; i++) py.Py_DecRef(arguments[i]);
    return result;
}

LOCAL void release(Instance *one) {
    for (int i = 0; i < METHODS; i++) py.Py_DecRef(one->methods[i]);
    for (int i = 0; i < 2 * TYPES; i++) {
        py.Py_DecRef(one->last[i].tuple);
        free(one->last[i].numbers);
    }
    py.Py_DecRef(one->queue);
    py.Py_DecRef(one->strings);
    py.Py_DecRef(one->slave);
    py.Py_DecRef(one->make);
    py.Py_DecRef(one->arguments);
    py.PyErr_Clear();
    for (size_t i = 0; i < one->category_count; i++) free(one->categories[i]);
    free(one->categories);
    free(one->name);
    free(one);
}

/* The instance of a handle, with the GIL; NULL, without it, where there is none or another call of it is under way. */
LOCAL Instance *begin(Component component, int *gil) {
    if (!is_handle((uintptr_t)component) || !enter(gil)) return NULL;
    Instance *one = (Instance *)find(component, 0);
    if (one == NULL || one->busy) {
        leave(*gil);
        return NULL;
    }
    one->busy = 1;
    return one;
}

LOCAL Status end(Instance *one, int gil, Status status) {
    Message *list = messages(one);
    Logger logger = one->logger;
    void *environment = one->environment;
    char *name = list ? copy(one->name, strlen(one->name)) : NULL;
    one->busy = 0;
    if (one->freed) release(one);
    leave(gil);
    /* the host's logger may call whatever it likes: it gets no GIL and nothing that is used afterwards */
    for (Message *m = list; m != NULL && m->text != NULL; m++) {
        if (name != NULL) logger(environment, name, m->status, m->category, m->text);
        free(m->category);
        free(m->text);
    }
    free(list);
    free(name);
    return status;
}

/* The call was wrong in itself: the slave fails with this sentence until it is reset or a state is set. */
LOCAL Status complain(Instance *one, const char *format, ...) {
    char text[TEXT];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    if (one->methods[COMPLAIN] != NULL) {
        PyObject *said = py.PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
        py.Py_DecRef(call(one->methods[COMPLAIN], 1, said, NULL, NULL));
    }
    py.PyErr_Clear();
    return ERROR;
}

/* The status that a method returned; the result is given up. */
LOCAL Status status_of(Instance *one, int method, PyObject *result) {
    long value = OK;
    if (result == NULL) {
        char text[TEXT];
        error_text(text);
        return complain(one, "%s: %s", NAMES[method], text);
    }
    if (result == py.false_) value = DISCARD;
    else if (result != py.none && result != py.true_) value = py.PyLong_AsLong(result);
    py.Py_DecRef(result);
    if (py.PyErr_Occurred()) {
        py.PyErr_Clear();
        return ERROR;
    }
    return value >= OK && value <= FATAL ? (Status)value : ERROR;
}

LOCAL Status simple(Component component, int method) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    return end(one, gil, status_of(one, method, py.PyObject_CallNoArgs(one->methods[method])));
}

/* ---- making an instance */

/* A new slave of the class and its bound methods; 0 with a Python error. */
LOCAL int bind(Instance *one, PyObject *make, PyObject *arguments) {
    PyObject *none = py.PyTuple_New(0), *slave = none ? py.PyObject_Call(make, none, arguments) : NULL, *methods[METHODS] = {0};
    PyObject *queue = slave ? py.PyObject_GetAttrString(slave, "log_queue") : NULL;
    PyObject *variables = queue ? py.PyObject_GetAttrString(slave, "vars") : NULL;
    Py_ssize_t count = variables ? py.PyObject_Size(variables) : -1;
    int whole = count >= 0;
    for (int i = 0; whole && i < METHODS; i++) {
        methods[i] = py.PyObject_GetAttrString(slave, NAMES[i]);
        if (methods[i] == NULL && i == COMPLAIN) py.PyErr_Clear(); /* other people's slaves have none */
        else whole = methods[i] != NULL;
    }
    py.Py_DecRef(none);
    py.Py_DecRef(variables);
    PyObject *olds[] = {one->slave, one->queue};
    if (whole) {
        for (int i = 0; i < METHODS; i++) {
            PyObject *old = one->methods[i];
            one->methods[i] = methods[i];
            py.Py_DecRef(old);
        }
        one->slave = slave;
        one->queue = queue;
        one->variables = count;
        py.Py_DecRef(olds[0]);
        py.Py_DecRef(olds[1]);
        return 1;
    }
    for (int i = 0; i < METHODS; i++) py.Py_DecRef(methods[i]);
    py.Py_DecRef(queue);
    py.Py_DecRef(slave);
    return 0;
}

/* The module that resources/slavemodule.txt names, imported once for all its copies; NULL with a Python error. */
LOCAL PyObject *import_slave(const char *resources, const char *module) {
    PyObject *modules = py.PySys_GetObject("modules"), *path = py.PySys_GetObject("path");
    if (modules != NULL && path != NULL && py.PyDict_GetItemString(modules, module) == NULL) {
        PyObject *folder = py.PyUnicode_DecodeFSDefault(resources), *tools = py.PyImport_ImportModule("importlib");
        PyObject *forget = tools ? py.PyObject_GetAttrString(tools, "invalidate_caches") : NULL;
        if (forget != NULL) py.Py_DecRef(py.PyObject_CallNoArgs(forget));
        if (folder != NULL) py.PyList_Insert(path, 0, folder);
        py.Py_DecRef(folder);
        py.Py_DecRef(tools);
        py.Py_DecRef(forget);
        py.PyErr_Clear();
    }
    return py.PyImport_ImportModule(module);
}

LOCAL PyObject *keywords(const char *name, const char *resources, int visible) {
    PyObject *made = py.PyDict_New();
    PyObject *values[] = {py.PyUnicode_DecodeUTF8(name, (Py_ssize_t)strlen(name), "replace"),
                          py.PyUnicode_DecodeFSDefault(resources), py.PyBool_FromLong(visible != 0)};
    const char *names[] = {"instance_name", "resources", "visible"};
    int whole = made != NULL;
    for (int i = 0; i < 3; i++) {
        whole = whole && values[i] != NULL && py.PyDict_SetItemString(made, names[i], values[i]) == 0;
        py.Py_DecRef(values[i]);
    }
    if (whole) return made;
    py.Py_DecRef(made);
    return NULL;
}

EXPORT Component fmi2Instantiate(const char *name, int type, const char *guid, const char *location, const Callbacks *callbacks,
                                 int visible, int logging) {
    char resources[PATH_MAX], module[256], own[256], why[TEXT];
    int gil;
    if (name == NULL) return no_instance(callbacks, logging, NULL, "the name of the instance is null. Remedy: give one");
    if (type != CO_SIMULATION)
        return no_instance(callbacks, logging, name,
                           "this FMU is for co-simulation only. Remedy: instantiate it as fmi2CoSimulation");
    if (!find_resources(location, resources)) {
        write_text(why, "there are no resources of this FMU at %s, nor beside its library. Remedy: unzip the whole FMU",
                   location ? location : "(null)");
        return no_instance(callbacks, logging, name, why);
    }
    if (!read_small(resources, "slavemodule.txt", module, sizeof module) || !read_small(resources, "guid.txt", own, sizeof own)) {
        write_text(why, "slavemodule.txt or guid.txt is missing in %s. Remedy: unzip the whole FMU", resources);
        return no_instance(callbacks, logging, name, why);
    }
    if (guid == NULL || strcmp(guid, own) != 0) {
        write_text(why, "the GUID %s is not that of this FMU, %s. Remedy: read modelDescription.xml of this very FMU",
                   guid ? guid : "(null)", own);
        return no_instance(callbacks, logging, name, why);
    }
    if (!python(resources, why)) return no_instance(callbacks, logging, name, why);
    Instance *one = calloc(1, sizeof *one);
    if (one == NULL || (one->name = copy(name, strlen(name))) == NULL || !enter(&gil)) {
        if (one != NULL) free(one->name);
        free(one);
        return no_instance(callbacks, logging, name, "no memory, or the Python of this process has ended");
    }
    if (callbacks != NULL) {
        one->logger = callbacks->logger;
        one->environment = callbacks->environment;
    }
    one->logging = logging != 0;
    PyObject *script = import_slave(resources, module);
    one->make = script ? py.PyObject_GetAttrString(script, "SLAVE") : NULL;
    one->arguments = one->make ? keywords(name, resources, visible) : NULL;
    py.Py_DecRef(script);
    if (one->arguments == NULL || !bind(one, one->make, one->arguments)) {
        error_text(why);
        release(one);
        leave(gil);
        return no_instance(callbacks, logging, name, why);
    }
    if (!watching && pthread_atfork(before_fork, after_fork_in_parent, after_fork_in_child) == 0) watching = 1;
    Component component = add(&one->entry, 0);
    one->busy = 1;
    end(one, gil, OK);
    return component;
}

EXPORT void fmi2FreeInstance(Component component) {
    int gil;
    if (!is_handle((uintptr_t)component) || !enter(&gil)) return;
    Instance *one = (Instance *)find(component, 0);
    if (one != NULL) {
        take_out(&one->entry);
        if (one->busy) one->freed = 1; /* by the call that is under way */
        else release(one);
    }
    leave(gil);
}

EXPORT Status fmi2Reset(Component component) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    Status status = OK;
    one->told = 0;
    if (!bind(one, one->make, one->arguments)) {
        char text[TEXT];
        error_text(text);
        status = complain(one, "reset: %s", text);
    }
    return end(one, gil, status);
}

/* ---- life */

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT Status fmi2SetDebugLogging(Component component, int logging, size_t count, const char *const categories[]) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    char **made = count > 0 && count <= 1000 && categories != NULL ? calloc(count, sizeof *made) : NULL;
    int whole = count == 0 || made != NULL;
    for (size_t i = 0; whole && i < count; i++)
        whole = categories[i] != NULL && (made[i] = copy(categories[i], strlen(categories[i]))) != NULL;
    if (!whole) {
        for (size_t i = 0; made != NULL && i < count; i++) free(made[i]);
        free(made);
        return end(one, gil, ERROR);
    }
    for (size_t i = 0; i < one->category_count; i++) free(one->categories[i]);
    free(one->categories);
    one->categories = made;
    one->category_count = count;
    one->logging = logging != 0;
    return end(one, gil, OK);
}

EXPORT Status fmi2SetupExperiment(Component component, int has_tolerance, double tolerance, double start, int has_stop,
                                  double stop) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    PyObject *numbers[] = {has_stop ? py.PyFloat_FromDouble(stop) : py.none,
                           has_tolerance ? py.PyFloat_FromDouble(tolerance) : py.none};
    if (!has_stop) py.Py_IncRef(py.none);
    if (!has_tolerance) py.Py_IncRef(py.none);
    PyObject *result = call(one->methods[SETUP], 3, py.PyFloat_FromDouble(start), numbers[0], numbers[1]);
    return end(one, gil, status_of(one, SETUP, result));
}

EXPORT Status fmi2EnterInitializationMode(Component component) { return simple(component, ENTER); }
EXPORT Status fmi2ExitInitializationMode(Component component) { return simple(component, LEAVE); }
EXPORT Status fmi2Terminate(Component component) { return simple(component, TERMINATE); }

EXPORT Status fmi2DoStep(Component component, double time, double step_size, int no_state_before) {
    int gil;
    (void)no_state_before; /* states are kept for as long as the host likes */
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    PyObject *result = call(one->methods[STEP], 2, py.PyFloat_FromDouble(time), py.PyFloat_FromDouble(step_size), NULL);
    return end(one, gil, status_of(one, STEP, result));
}

/* ---- values */

LOCAL const char *const KINDS[TYPES] = {"Real", "Integer", "Boolean", "String"};

/* References as a tuple; hosts ask for the same ones again and again. */
LOCAL PyObject *references(Instance *one, int slot, const Reference *numbers, size_t count) {
    if (one->last[slot].tuple == NULL || one->last[slot].count != count ||
        memcmp(one->last[slot].numbers, numbers, count * sizeof *numbers) != 0) {
        PyObject *made = py.PyTuple_New((Py_ssize_t)count);
        Reference *kept = malloc(count * sizeof *numbers);
        int whole = made != NULL && kept != NULL;
        for (size_t i = 0; whole && i < count; i++) {
            PyObject *number = py.PyLong_FromUnsignedLong(kept[i] = numbers[i]);
            whole = number != NULL && py.PyTuple_SetItem(made, (Py_ssize_t)i, number) == 0;
        }
        if (!whole) {
            py.Py_DecRef(made);
            free(kept);
            return NULL;
        }
        py.Py_DecRef(one->last[slot].tuple);
        free(one->last[slot].numbers);
        one->last[slot].tuple = made;
        one->last[slot].numbers = kept;
        one->last[slot].count = count;
    }
    py.Py_IncRef(one->last[slot].tuple);
    return one->last[slot].tuple;
}

/* Whether an access can be made at all; if not, the slave has been told. */
LOCAL int sound(Instance *one, const char *what, int type, const Reference *numbers, size_t count, const void *values) {
    if (numbers == NULL || values == NULL)
        complain(one, "fmi2%s%s: null pointers for %zu values. Remedy: give arrays of that length", what, KINDS[type], count);
    else if (count > (size_t)one->variables)
        complain(one, "fmi2%s%s: %zu values of an FMU with %zd variables. Remedy: give the length of the arrays", what,
                 KINDS[type], count, one->variables);
    else return 1;
    return 0;
}

LOCAL int unpack(int type, PyObject *item, void *values, size_t i) {
    if (type == REAL) ((double *)values)[i] = py.PyFloat_AsDouble(item);
    else if (type == INTEGER) ((int *)values)[i] = (int)py.PyLong_AsLong(item);
    else if (type == BOOLEAN) ((int *)values)[i] = py.PyObject_IsTrue(item);
    else return (((const char **)values)[i] = py.PyUnicode_AsUTF8AndSize(item, NULL)) != NULL;
    return 1;
}

LOCAL Status get(Component component, int type, const Reference *numbers, size_t count, void *values) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    if (count == 0) return end(one, gil, OK);
    if (!sound(one, "Get", type, numbers, count, values)) return end(one, gil, ERROR);
    PyObject *result = call(one->methods[GET + type], 1, references(one, type, numbers, count), NULL, NULL);
    PyObject *items = result ? py.PySequence_Tuple(result) : NULL;
    py.Py_DecRef(result);
    Py_ssize_t length = items ? py.PyTuple_Size(items) : -1;
    int whole = length == (Py_ssize_t)count || length == (Py_ssize_t)count + 1;
    for (size_t i = 0; whole && i < count; i++) whole = unpack(type, py.PyTuple_GetItem(items, (Py_ssize_t)i), values, i);
    Status status = OK;
    if (!whole || py.PyErr_Occurred()) {
        char text[TEXT] = "there are not as many values as references";
        if (py.PyErr_Occurred()) error_text(text);
        status = complain(one, "%s: %s", NAMES[GET + type], text);
    } else if (length > (Py_ssize_t)count) {
        PyObject *last = py.PyTuple_GetItem(items, length - 1);
        py.Py_IncRef(last);
        status = status_of(one, GET + type, last);
    }
    if (type == STRING) { /* the texts live until the next call */
        PyObject *old = one->strings;
        one->strings = items;
        items = old;
    }
    py.Py_DecRef(items);
    return end(one, gil, status);
}

LOCAL PyObject *pack(int type, const void *values, size_t i) {
    if (type == REAL) return py.PyFloat_FromDouble(((const double *)values)[i]);
    if (type == INTEGER) return py.PyLong_FromLong(((const int *)values)[i]);
    if (type == BOOLEAN) return py.PyBool_FromLong(((const int *)values)[i] != 0);
    const char *text = ((const char *const *)values)[i];
    if (text == NULL) {
        py.Py_IncRef(py.none);
        return py.none;
    }
    PyObject *made = py.PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), NULL);
    if (made != NULL) return made;
    py.PyErr_Clear(); /* no UTF-8: the slave is given the bytes and says so */
    return py.PyBytes_FromStringAndSize(text, (Py_ssize_t)strlen(text));
}

LOCAL Status set(Component component, int type, const Reference *numbers, size_t count, const void *values) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    if (count == 0) return end(one, gil, OK);
    if (!sound(one, "Set", type, numbers, count, values)) return end(one, gil, ERROR);
    PyObject *items = py.PyTuple_New((Py_ssize_t)count);
    for (size_t i = 0; items != NULL && i < count; i++) {
        PyObject *item = pack(type, values, i);
        if (item == NULL || py.PyTuple_SetItem(items, (Py_ssize_t)i, item) != 0) {
            py.Py_DecRef(items);
            items = NULL;
        }
    }
    PyObject *result = call(one->methods[SET + type], 2, references(one, TYPES + type, numbers, count), items, NULL);
    return end(one, gil, status_of(one, SET + type, result));
}

#define ACCESS(name, type, got, given) \
    EXPORT Status fmi2Get##name(Component component, const Reference *numbers, size_t count, got *values) { \
        return get(component, type, numbers, count, values); \
    } \
    EXPORT Status fmi2Set##name(Component component, const Reference *numbers, size_t count, given *values) { \
        return set(component, type, numbers, count, values); \
    }
ACCESS(Real, REAL, double, const double)
ACCESS(Integer, INTEGER, int, const int)
ACCESS(Boolean, BOOLEAN, int, const int)
ACCESS(String, STRING, const char *, const char *const)

/* ---- states: they outlive the instance that they were taken of, and may be set in any other of this library */

LOCAL Status keep(Instance *one, int method, PyObject *state, State *where) {
    if (state == NULL) return status_of(one, method, NULL);
    if (state == py.none) {
        py.Py_DecRef(state);
        return ERROR;
    }
    Kept *kept = (Kept *)find(*where, 1); /* a state at hand is written over */
    if (kept != NULL) {
        PyObject *old = kept->state;
        kept->state = state;
        py.Py_DecRef(old);
        return OK;
    }
    if ((kept = calloc(1, sizeof *kept)) == NULL) {
        py.Py_DecRef(state);
        return ERROR;
    }
    kept->state = state;
    *where = add(&kept->entry, 1);
    return OK;
}

EXPORT Status fmi2GetFMUstate(Component component, State *state) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    if (state == NULL) return end(one, gil, ERROR);
    return end(one, gil, keep(one, SAVE, py.PyObject_CallNoArgs(one->methods[SAVE]), state));
}

EXPORT Status fmi2SetFMUstate(Component component, State state) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    Kept *kept = (Kept *)find(state, 1);
    if (kept == NULL)
        return end(one, gil, complain(one, "fmi2SetFMUstate: %s. Remedy: set a state that fmi2GetFMUstate or "
                                           "fmi2DeSerializeFMUstate of this library gave and that is not freed",
                                      state ? "there is no such state" : "the state is null"));
    one->told = 0;
    py.Py_IncRef(kept->state);
    return end(one, gil, status_of(one, RESTORE, call(one->methods[RESTORE], 1, kept->state, NULL, NULL)));
}

EXPORT Status fmi2FreeFMUstate(Component component, State *where) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    /* some hosts hand in the state itself instead of its address */
    int itself = is_handle((uintptr_t)where);
    if (where == NULL || (!itself && *where == NULL)) return end(one, gil, OK);
    Kept *kept = (Kept *)find(itself ? (State)where : *where, 1);
    if (kept == NULL) return end(one, gil, ERROR);
    take_out(&kept->entry);
    py.Py_DecRef(kept->state);
    free(kept);
    if (!itself) *where = NULL;
    return end(one, gil, OK);
}

/* The bytes of a state as a new reference; NULL where there are none. */
LOCAL PyObject *bytes_of(Instance *one, State state, char **bytes, Py_ssize_t *size) {
    Kept *kept = (Kept *)find(state, 1);
    if (kept == NULL) return NULL;
    py.Py_IncRef(kept->state);
    PyObject *made = call(one->methods[TO_BYTES], 1, kept->state, NULL, NULL);
    if (made != NULL && py.PyBytes_AsStringAndSize(made, bytes, size) == 0) return made;
    py.Py_DecRef(made);
    py.PyErr_Clear();
    return NULL;
}

EXPORT Status fmi2SerializedFMUstateSize(Component component, State state, size_t *size) {
    int gil;
    char *bytes;
    Py_ssize_t length = 0;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    PyObject *made = size ? bytes_of(one, state, &bytes, &length) : NULL;
    if (made != NULL) *size = (size_t)length;
    py.Py_DecRef(made);
    return end(one, gil, made ? OK : ERROR);
}

EXPORT Status fmi2SerializeFMUstate(Component component, State state, char *to, size_t size) {
    int gil;
    char *bytes;
    Py_ssize_t length = 0;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    PyObject *made = to ? bytes_of(one, state, &bytes, &length) : NULL;
    int fits = made != NULL && (size_t)length == size; /* a part of a state is none, and there is no more than the whole */
    if (fits) memcpy(to, bytes, size);
    py.Py_DecRef(made);
    return end(one, gil, fits ? OK : ERROR);
}

EXPORT Status fmi2DeSerializeFMUstate(Component component, const char *from, size_t size, State *state) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    if (state == NULL || (from == NULL && size > 0) || size > (size_t)PTRDIFF_MAX / 2) return end(one, gil, ERROR);
    PyObject *bytes = py.PyBytes_FromStringAndSize(from ? from : "", (Py_ssize_t)size);
    return end(one, gil, keep(one, FROM_BYTES, call(one->methods[FROM_BYTES], 1, bytes, NULL, NULL), state));
}

/* ---- what these FMUs do not do, as their descriptions say; nothing changes */

LOCAL Status unsupported(Component component, Status status) {
    int gil;
    Instance *one = begin(component, &gil);
    return one ? end(one, gil, status) : ERROR;
}

EXPORT Status fmi2GetDirectionalDerivative(Component component, const Reference *unknowns, size_t unknown_count,
                                           const Reference *knowns, size_t known_count, const double *seed, double *result) {
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)result;
    return unsupported(component, ERROR);
}

EXPORT Status fmi2SetRealInputDerivatives(Component component, const Reference *numbers, size_t count, const int *orders,
                                          const double *values) {
    (void)numbers, (void)count, (void)orders, (void)values;
    return unsupported(component, ERROR);
}

EXPORT Status fmi2GetRealOutputDerivatives(Component component, const Reference *numbers, size_t count, const int *orders,
                                           double *values) {
    (void)numbers, (void)count, (void)orders, (void)values;
    return unsupported(component, ERROR);
}

EXPORT Status fmi2CancelStep(Component component) { return unsupported(component, ERROR); } /* no step is ever pending */

EXPORT Status fmi2GetStatus(Component component, int kind, Status *value) {
    (void)kind, (void)value;
    return unsupported(component, DISCARD);
}

EXPORT Status fmi2GetRealStatus(Component component, int kind, double *value) {
    int gil;
    Instance *one = begin(component, &gil);
    if (one == NULL) return ERROR;
    PyObject *time = kind == LAST_SUCCESSFUL_TIME && value ? py.PyObject_GetAttrString(one->slave, "time") : NULL;
    double number = time ? py.PyFloat_AsDouble(time) : 0.0;
    int known = time != NULL && !py.PyErr_Occurred();
    if (known) *value = number;
    py.Py_DecRef(time);
    py.PyErr_Clear();
    return end(one, gil, known ? OK : DISCARD);
}

EXPORT Status fmi2GetIntegerStatus(Component component, int kind, int *value) {
    (void)kind, (void)value;
    return unsupported(component, DISCARD);
}

EXPORT Status fmi2GetBooleanStatus(Component component, int kind, int *value) {
    int known = kind == TERMINATED && value != NULL;
    Status status = unsupported(component, known ? OK : DISCARD);
    if (status == OK) *value = 0; /* these FMUs never want to end of their own accord */
    return status;
}

EXPORT Status fmi2GetStringStatus(Component component, int kind, const char **value) {
    (void)kind, (void)value;
    return unsupported(component, DISCARD);
}
