// `ssv log`: a recorded log of the bus as tables.
#include <argp.h>
#include <inttypes.h>
#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "commands.h"
#include "report/tables.h"
#include "wire/tree.h"

static const char doc[] =
    "Turns a log that lcm-logger recorded into tables: one CSV file for each kind of message, and for the legs, arcs, "
    "segments, events, candidates, obstacles and parts that they list."
    "\vExamples:\n"
    "  build/venv/bin/lcm-logger --channel 'SSV_.*' tank.lcmlog\n"
    "                                       records, until Ctrl-C\n"
    "  ssv log tank.lcmlog --to tank\n"
    "\n"
    "messages.csv has every message of the log, with its type, and whether it could be read. In the other tables "
    "column message says which one a row comes from, received_us when it was received, in microseconds since 1970; "
    "columns have the names of the messages' fields, units last (lcmtypes/README.md). Vectors end in x, y, z, "
    "quaternions in w, x, y, z. DIR is made if there is none; tables in it are replaced.\n"
    "\n"
    "Exit codes:\n"
    "   0  written\n"
    "   2  FILE is no log, or cannot be read\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. DIR cannot be written\n";

enum { KEY_TO = 't' };

static const struct argp_option options[] = {{"to", KEY_TO, "DIR", 0, "The folder that the tables are written to", 0},
                                             {0}};

typedef struct {
    const char *path, *folder;
} arguments_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* const arguments = state->input;
    switch (key) {
        case KEY_TO: arguments->folder = argument; return 0;
        case ARGP_KEY_ARG:
            if (arguments->path != NULL) argp_error(state, "one log at a time, but there is also '%s'", argument);
            arguments->path = argument;
            return 0;
        case ARGP_KEY_END:
            if (arguments->path != NULL && arguments->folder == NULL) argp_error(state, "--to which folder?");
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "which log?"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

/// What was found in a log.
typedef struct {
    long read, others;
    long long left_bytes; ///< at its end, which are no whole message
} found_t;

static bool add_all(lcm_eventlog_t* log, long long size, tables_t* tables, found_t* found) {
    lcm_eventlog_event_t* event;
    long long end = 0;
    while ((event = lcm_eventlog_read_next_event(log)) != NULL) {
        const tables_message_t message = {event->eventnum, event->timestamp, event->channel, event->data,
                                          (size_t)event->datalen};
        tree_make_harmless(event->channel);
        if (tables_add(tables, &message) != NULL)
            found->read++;
        else
            found->others++;
        lcm_eventlog_free_event(event);
        end = ftell(log->f);
    }
    found->left_bytes = size - end;
    return found->read + found->others > 0 || size == 0;
}

static void show(const tables_t* tables, const found_t* found, const char* folder) {
    long rows = 0;
    printf("%ld messages of ours, %ld others; in %s:\n", found->read, found->others, folder);
    for (int i = 0; tables_name(tables, i, &rows) != NULL; i++) {
        if (rows > 0) printf("  %-20s %8ld rows\n", tables_name(tables, i, &rows), rows);
    }
    if (found->left_bytes > 0)
        printf("  %lld bytes at the end of the log are no whole message: it was cut off\n", found->left_bytes);
}

int log_command(int argc, char** argv) {
    static const struct argp parser = {options, parse_option, "FILE", doc, NULL, NULL, NULL};
    arguments_t arguments = {NULL, NULL};
    char name[] = "ssv log", error[1024] = "", path[256];
    char* const command = argv[0];
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);
    argv[0] = command;

    struct stat status;
    snprintf(path, sizeof path, "%s", arguments.path);
    tree_make_harmless(path);
    const bool is_file = stat(arguments.path, &status) == 0 && S_ISREG(status.st_mode);
    lcm_eventlog_t* const log = is_file ? lcm_eventlog_create(arguments.path, "r") : NULL;
    if (log == NULL) {
        fprintf(stderr, "ssv: %s: %s\n", path, is_file ? "cannot be opened" : "no regular file");
        return EXIT_INVALID;
    }
    int code = EXIT_FAILED;
    found_t found = {0, 0, 0};
    tables_t* const tables = tables_open(arguments.folder, error, sizeof error);
    if (tables != NULL) {
        const bool is_log = add_all(log, status.st_size, tables, &found);
        if (is_log) show(tables, &found, arguments.folder);
        code = !tables_close(tables, error, sizeof error) ? EXIT_FAILED : is_log ? EXIT_OK : EXIT_INVALID;
        if (!is_log && error[0] == '\0')
            snprintf(error, sizeof error, "%s: no log of lcm-logger: not one message in it", path);
    }
    if (error[0] != '\0') fprintf(stderr, "ssv: %s\n", error);
    lcm_eventlog_destroy(log);
    return code;
}
