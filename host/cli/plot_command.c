// `ssv plot`: a plan's thrusts, speed and clearance over time, on paper or in the terminal, drawn by gnuplot.
#define _GNU_SOURCE
#include <argp.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "commands.h"
#include "output.h"
#include "processes.h"
#include "report/plot.h"
#include "report/record.h"

static const char doc[] =
    "Plots a plan: its six thrusts, speed and clearance over time."
    "\vExamples:\n"
    "  ssv plot plan.json                       in the terminal\n"
    "  ssv plot plan.json --output plan.svg     for paper, beside plan.csv, plan.gp\n"
    "  gnuplot plan.gp                          again, after a change of either\n"
    "\n"
    "FILE is what `ssv plan --format json` wrote, or several tasks one after the other as host/FORMATS.md tells. "
    "gnuplot draws (Debian package gnuplot-nox). plan.csv has one row for each instant, with names and units at its "
    "top, for other programs, too.\n"
    "\n"
    "Exit codes:\n"
    "   0  drawn\n"
    "   2  FILE is refused: it cannot be read, a key or a value is wrong, or it\n"
    "      holds no plan; the message names the place\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. there is no gnuplot, or a file cannot be written\n";

enum { KEY_OUTPUT = 'o', COLUMNS = 100, LINES = 45, LINES_LEAST = 24, SUFFIX = 4 };

static const struct argp_option options[] = {
    {"output", KEY_OUTPUT, "FILE.svg", 0,
     "Write an SVG there, and FILE.csv and FILE.gp beside it, instead of drawing in the terminal", 0},
    {0}};

typedef struct {
    const char *path, *output_path;
} arguments_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* const arguments = state->input;
    const size_t length = argument == NULL ? 0 : strlen(argument);
    switch (key) {
        case KEY_OUTPUT:
            if (length <= SUFFIX || length >= PATH_MAX || strcmp(argument + length - SUFFIX, ".svg") != 0)
                argp_error(state, "--output %s: the name of an SVG ends in .svg", argument);
            arguments->output_path = argument;
            return 0;
        case ARGP_KEY_ARG:
            if (arguments->path != NULL) argp_error(state, "one file at a time, but there is also '%s'", argument);
            arguments->path = argument;
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "which file?"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

/// What plot.h writes, as a text that the caller frees. @return NULL with the exit code after a line on standard error.
static char* text_of(bool (*write)(FILE* out, const plot_t* plot, char* error, size_t error_size), const plot_t* plot,
                     size_t* size, int* code) {
    char *text = NULL, error[512] = "out of memory";
    FILE* const memory = open_memstream(&text, size);
    const bool sound = memory != NULL && write(memory, plot, error, sizeof error);
    *code = memory == NULL || (fclose(memory) != 0 && sound) ? EXIT_FAILED : sound ? EXIT_OK : EXIT_INVALID;
    if (*code == EXIT_OK) return text;
    fprintf(stderr, "ssv: %s: %s\n", plot->record->title, error);
    free(text);
    return NULL;
}

/// Puts what plot.h writes into a file. @return the exit code.
static int write_file(const char* path, bool (*write)(FILE* out, const plot_t* plot, char* error, size_t error_size),
                      const plot_t* plot) {
    size_t size = 0;
    int code = EXIT_OK;
    char* const text = text_of(write, plot, &size, &code);
    if (text != NULL && !output_write(path, text, size)) code = EXIT_FAILED;
    free(text);
    return code;
}

/// Has gnuplot do what the script says. @return what it writes, which the caller frees; NULL after a line on standard
/// error.
static char* draw(const char* script, size_t script_size) {
    char error[512], program[PATH_MAX];
    char* argv[] = {"gnuplot", NULL};
    process_t gnuplot = {.output = -1, .log = -1};
    char* drawn = NULL;
    if (!process_find("gnuplot", program, sizeof program)) {
        fprintf(stderr, "ssv: there is no gnuplot, which draws; on Debian: apt-get install gnuplot-nox\n");
        return NULL;
    }
    const int input = process_scratch();
    const bool written = input >= 0 && write(input, script, script_size) == (ssize_t)script_size;
    if (!written || !process_start(&gnuplot, program, argv, input, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", written ? error : "the system gives no files for a plot");
    } else if (process_wait(&gnuplot) == 0) {
        drawn = process_output(&gnuplot);
    } else {
        char* const log = process_log(&gnuplot);
        fprintf(stderr, "ssv: gnuplot does not draw this: %s\n", log == NULL ? "" : log);
        free(log);
    }
    process_close(&gnuplot);
    if (input >= 0) close(input);
    return drawn;
}

/// @return the exit code.
static int draw_plot(const plot_t* plot, const char* output_path) {
    size_t size = 0;
    int code = EXIT_OK;
    char* const script = text_of(plot_script, plot, &size, &code);
    char* const drawn = script == NULL ? NULL : draw(script, size);
    if (script != NULL && (drawn == NULL || !output_write(output_path, drawn, strlen(drawn)))) code = EXIT_FAILED;
    free(drawn);
    free(script);
    return code;
}

static int plot_in_terminal(const record_t* record) {
    struct winsize window;
    const bool is_known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
    plot_t plot = {.record = record, .columns = COLUMNS, .lines = LINES};
    if (is_known) plot.columns = window.ws_col - 1;
    if (is_known && window.ws_row > LINES_LEAST) plot.lines = window.ws_row - 2;
    return draw_plot(&plot, NULL);
}

/// The table and the script first, so that they are there where gnuplot is not.
static int plot_on_paper(const record_t* record, const char* svg_path) {
    char csv_path[PATH_MAX], script_path[PATH_MAX];
    const int stem = (int)(strlen(svg_path) - SUFFIX);
    snprintf(csv_path, sizeof csv_path, "%.*s.csv", stem, svg_path);
    snprintf(script_path, sizeof script_path, "%.*s.gp", stem, svg_path);
    const plot_t plot = {.record = record, .csv_path = csv_path};
    const plot_t kept = {.record = record, .csv_path = basename(csv_path), .output_path = basename(svg_path)};
    int code = write_file(csv_path, plot_table, &plot);
    if (code == EXIT_OK) code = write_file(script_path, plot_script, &kept);
    return code == EXIT_OK ? draw_plot(&plot, svg_path) : code;
}

int plot_command(int argc, char** argv) {
    static const struct argp parser = {options, parse_option, "FILE", doc, NULL, NULL, NULL};
    arguments_t arguments = {NULL, NULL};
    char name[] = "ssv plot", error[1024];
    char* const command = argv[0];
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);
    argv[0] = command;

    record_t record;
    if (!record_read(arguments.path, &record, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    const int code =
        arguments.output_path == NULL ? plot_in_terminal(&record) : plot_on_paper(&record, arguments.output_path);
    record_free(&record);
    return code;
}
