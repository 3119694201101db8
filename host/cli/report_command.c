// `ssv report`: a plan, a flight or an assembly as a page that opens anywhere.
#include <argp.h>
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "output.h"
#include "report/page.h"
#include "report/picture.h"
#include "report/record.h"
#include "task_options.h"

static const char doc[] =
    "Shows a plan or a flight as a picture that moves: one HTML file with the scene in three dimensions, the thrusts "
    "in step with it, clearance, price and legs. It opens in any browser, from the disk and without a network."
    "\vExamples:\n"
    "  ssv plan task.yaml --format json --output plan.json\n"
    "  ssv report plan.json --output plan.html\n"
    "  ssv plan task.yaml --format json | ssv report - --output plan.html\n"
    "  ssv fly task.yaml --sim --format json --output flight.json\n"
    "  ssv report flight.json --output flight.html\n"
    "                                       what was flown beside what was planned\n"
    "\n"
    "FILE is what `ssv plan`, `ssv fly` or `ssv schedule` wrote with --format json, or several tasks one after the "
    "other as host/FORMATS.md tells. A plan that does not pass its check is drawn all the same, and the page says so. "
    "What "
    "comes closer than the margin is red.\n"
    "\n"
    "Exit codes:\n"
    "   0  written\n"
    "   2  FILE is refused: it cannot be read, a key or a value is wrong, or it\n"
    "      holds no plan; the message names the place\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. the page cannot be written\n";

enum { KEY_OUTPUT = 'o' };

static const struct argp_option options[] = {
    {"output", KEY_OUTPUT, "FILE", 0, "Write there instead of to standard output, which is -", 0}, {0}};

typedef struct {
    const char *path, *output_path;
} arguments_t;

typedef struct {
    const page_t* page;
    const json_t* data;
} report_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* const arguments = state->input;
    switch (key) {
        case KEY_OUTPUT: arguments->output_path = argument; return 0;
        case ARGP_KEY_ARG:
            if (arguments->path != NULL) argp_error(state, "one file at a time, but there is also '%s'", argument);
            arguments->path = argument;
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "which file?"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static bool write_page(FILE* out, const void* content) {
    const report_t* const report = content;
    return page_write(out, report->page, report->data);
}

int report_command(int argc, char** argv) {
    static const struct argp parser = {options, parse_option, "FILE", doc, NULL, NULL, NULL};
    arguments_t arguments = {NULL, NULL};
    char name[] = "ssv report", error[1024];
    char* const command = argv[0];
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);
    argv[0] = command;

    record_t record;
    if (!record_read(arguments.path, &record, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    int code = EXIT_INVALID;
    page_t page = {NULL, 0, 0};
    json_t* const data = picture_of(&record, error, sizeof error);
    char* const folder = data == NULL ? NULL : task_data_folder(SSV_REPORT_FROM_BIN);
    if (data != NULL) {
        code = EXIT_FAILED;
        if (folder == NULL) snprintf(error, sizeof error, "out of memory");
    }
    if (folder != NULL && page_read(folder, &page, error, sizeof error)) {
        const report_t report = {&page, data};
        if (output_report(arguments.output_path, write_page, &report)) code = EXIT_OK;
    } else {
        fprintf(stderr, "ssv: %s\n", error);
    }
    free(folder);
    page_free(&page);
    json_decref(data);
    record_free(&record);
    return code;
}
