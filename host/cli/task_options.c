#define _DEFAULT_SOURCE
#include "task_options.h"

#include <argp.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "processes.h"
#include "wire/names.h"

#define METHOD_DEFAULT "optimal"
#define EFFORT_DEFAULT "quick"

enum {
    KEY_LCM = 256,
    KEY_WEIGHTS,
    KEY_METHOD,
    KEY_EFFORT,
    KEY_SCALAR,
    KEY_FORMAT,
    KEY_OUTPUT,
    KEY_TIMEOUT,
    KEY_CANDIDATES,
    KEY_FRONT,
    KEY_SIM,
    KEY_CONDITIONS,
    KEY_SEED,
    KEY_RATE
};

// Of the question alone.
#define QUESTION_OPTIONS                                                                                               \
    {"weights", KEY_WEIGHTS, "W1,W2", 0, "Weights of time [1/s] and impulse [1/(N s)] instead of the file's", 0},      \
        {"method",                                                                                                     \
         KEY_METHOD,                                                                                                   \
         "optimal|paper",                                                                                              \
         0,                                                                                                            \
         "What decides the free choices, instead of the file's (default " METHOD_DEFAULT ")",                          \
         0},                                                                                                           \
        {"effort",                                                                                                     \
         KEY_EFFORT,                                                                                                   \
         "quick|best",                                                                                                 \
         0,                                                                                                            \
         "How much method optimal tries, instead of the file's (default " EFFORT_DEFAULT ")",                          \
         0},                                                                                                           \
        {"output", KEY_OUTPUT, "FILE", 0, "Write there instead of to standard output, which is -", 0}

#define DETAIL_OPTIONS                                                                                                   \
    {"candidates", KEY_CANDIDATES, NULL, 0, "Also search and show every (contact, height); may find a lower J", 0},      \
        {"front", KEY_FRONT, NULL, 0, "Also show what time and impulse can be traded for; takes some ten times as long", \
         0}

static const struct argp_option answer_options[] = {
    {"lcm", KEY_LCM, "URL", OPTION_ARG_OPTIONAL, "Ask a running ssv-plannerd over LCM, instead of computing in process",
     0},
    {"scalar", KEY_SCALAR, "double|float|fixed", 0,
     "The arithmetic that the planner computes in (default " SSV_DEFAULT_SCALAR
     "); with --lcm a running planner of that one is asked",
     0},
    {"format", KEY_FORMAT, "table|json", 0, "For people (default) or for programs", 0},
    {"timeout", KEY_TIMEOUT, "S", 0,
     "How long to wait for an answer over LCM, of many for the next one [s] (default 5)", 0},
    QUESTION_OPTIONS,
    DETAIL_OPTIONS,
    {0},
};

static const struct argp_option question_options[] = {
    {"format", KEY_FORMAT, "yaml|json", 0, "For people (default) or for programs", 0},
    QUESTION_OPTIONS,
    DETAIL_OPTIONS,
    {0},
};

static const struct argp_option flight_options[] = {
    {"sim", KEY_SIM, NULL, 0, "In simulation: starts ssv-sim and an ssv-plannerd for this flight, and ends them", 0},
    {"conditions", KEY_CONDITIONS, "NAME|FILE", 0,
     "Disturbances and tolerances of the simulated flight (default: none)", 0},
    {"seed", KEY_SEED, "N", 0, "Seed of the disturbances; the same seed is the same flight (default 1)", 0},
    {"rate", KEY_RATE, "R|max", 0, "Simulated seconds per second (default max, as fast as it goes)", 0},
    {"lcm", KEY_LCM, "URL", OPTION_ARG_OPTIONAL,
     "Without --sim: MOVES A REAL VEHICLE, by the running ssv-plannerd that hears one. With --sim: the bus for the "
     "simulated flight",
     0},
    {"scalar", KEY_SCALAR, "double|float|fixed", 0,
     "The arithmetic that the planner computes in (default " SSV_DEFAULT_SCALAR
     "); without --sim a running planner of that one is asked",
     0},
    {"format", KEY_FORMAT, "table|json", 0, "For people (default) or for programs", 0},
    {"timeout", KEY_TIMEOUT, "S", 0,
     "How long to wait for the planner's answer, and for news of the flight [s] (default 5)", 0},
    QUESTION_OPTIONS,
    {0},
};

typedef struct {
    task_options_t* options;
    int max_paths;
    task_use_t use;
} input_t;

bool task_parse_weights(const char* text, double weights[2]) {
    const char* const comma = strchr(text, ',');
    char first[64];
    if (comma == NULL || (size_t)(comma - text) >= sizeof first) {
        return false;
    }
    snprintf(first, sizeof first, "%.*s", (int)(comma - text), text);
    return tree_number(first, &weights[0]) && tree_number(comma + 1, &weights[1]);
}

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    input_t* input = state->input;
    task_options_t* options = input->options;
    switch (key) {
        case KEY_LCM:
            options->over_lcm = true;
            options->lcm_url = argument;
            if (argument == NULL && state->next < state->argc && strstr(state->argv[state->next], "://") != NULL) {
                options->lcm_url = state->argv[state->next++]; // argp leaves "--lcm URL" without a "=" to us
            }
            return 0;
        case KEY_WEIGHTS:
            if (!task_parse_weights(argument, options->weights)) {
                argp_error(state, "--weights %s: not two numbers with a comma between, e.g. 1,0.5", argument);
            }
            options->weights_given = true;
            return 0;
        case KEY_METHOD:
            options->method = name_find(&names_method, argument);
            if (options->method < 0) {
                argp_error(state, "--method %s: there are optimal and paper", argument);
            }
            return 0;
        case KEY_EFFORT:
            options->effort = name_find(&names_effort, argument);
            if (options->effort < 0) {
                argp_error(state, "--effort %s: there are quick and best", argument);
            }
            return 0;
        case KEY_SCALAR:
            if (strcmp(argument, "double") != 0 && strcmp(argument, "float") != 0 && strcmp(argument, "fixed") != 0) {
                argp_error(state, "--scalar %s: there are double, float and fixed", argument);
            }
            options->scalar = argument;
            return 0;
        case KEY_CANDIDATES: options->want_candidates = true; return 0;
        case KEY_FRONT: options->want_front = true; return 0;
        case KEY_FORMAT:
            options->as_json = strcmp(argument, "json") == 0;
            if (!options->as_json && strcmp(argument, input->use != TASK_SHOWN ? "table" : "yaml") != 0) {
                argp_error(state, "--format %s: there are %s and json", argument,
                           input->use != TASK_SHOWN ? "table" : "yaml");
            }
            return 0;
        case KEY_OUTPUT: options->output_path = argument; return 0;
        case KEY_TIMEOUT:
            if (!tree_number(argument, &options->timeout_s) ||
                !(options->timeout_s > 0 && options->timeout_s <= 3600)) {
                argp_error(state, "--timeout %s: not a number of seconds in (0, 3600]", argument);
            }
            return 0;
        case KEY_SIM: options->in_simulation = true; return 0;
        case KEY_CONDITIONS: options->conditions = argument; return 0;
        case KEY_SEED:
            if (argument[0] == '\0' || strlen(argument) > 18 || argument[strspn(argument, "0123456789")] != '\0') {
                argp_error(state, "--seed %s: not a whole number", argument);
            }
            options->seed = argument;
            return 0;
        case KEY_RATE:
            options->rate = 0;
            if (strcmp(argument, "max") != 0 &&
                (!tree_number(argument, &options->rate) || !(options->rate >= 1e-3 && options->rate <= 1e6))) {
                argp_error(state, "--rate %s: neither max nor a number in [0.001, 1e6]", argument);
            }
            options->rate_given = true;
            return 0;
        case ARGP_KEY_END:
            if (input->use == TASK_FLOWN && !options->in_simulation && !options->over_lcm) {
                argp_error(state, "--sim flies in simulation, --lcm moves a real vehicle: say which");
            }
            if (!options->in_simulation &&
                (options->conditions != NULL || options->seed != NULL || options->rate_given)) {
                argp_error(state, "--conditions, --seed and --rate are for a simulated flight; they need --sim");
            }
            return 0;
        case ARGP_KEY_ARG:
            if (options->num_paths == input->max_paths) {
                argp_error(state, "no more than 1 scenario at a time, but there is also '%s'", argument);
            }
            snprintf(options->shown[options->num_paths], sizeof options->shown[0], "%s",
                     strcmp(argument, "-") == 0 ? "standard input" : argument);
            tree_make_harmless(options->shown[options->num_paths]);
            options->paths[options->num_paths++] = argument;
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "which scenario file?"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

char* task_data_folder(const char* from_bin) {
    char joined[2 * PATH_MAX];
    process_path(from_bin, joined, sizeof joined);
    char* const resolved = realpath(joined, NULL);
    return resolved != NULL ? resolved : strdup(joined);
}

/// Runs the program beside this one that has a planner of that scalar in it, with the same arguments.
__attribute__((noreturn)) static void hand_over(const char* scalar, char* command, int argc, char** argv) {
    const bool is_default = strcmp(scalar, SSV_DEFAULT_SCALAR) == 0;
    char name[16], program[PATH_MAX + sizeof name];
    char** const arguments = calloc((size_t)argc + 2, sizeof *arguments);
    snprintf(name, sizeof name, "ssv%s%s", is_default ? "" : "-", is_default ? "" : scalar);
    process_path(name, program, sizeof program);
    if (arguments != NULL) {
        arguments[0] = name;
        arguments[1] = command;
        memcpy(&arguments[2], &argv[1], (size_t)(argc - 1) * sizeof *arguments);
        execv(program, arguments);
    }
    fprintf(stderr, "ssv: cannot run %s, which plans in %s: %s; install it beside this program\n", program, scalar,
            strerror(errno));
    exit(EXIT_FAILED);
}

void task_options_parse(task_options_t* options, const char* doc, int max_paths, task_use_t use, int argc,
                        char** argv) {
    const struct argp parser = {.options = use == TASK_ANSWERED ? answer_options
                                           : use == TASK_FLOWN  ? flight_options
                                                                : question_options,
                                .parser = parse_option,
                                .args_doc = use == TASK_FLOWN ? "SCENARIO|STRUCTURE"
                                            : max_paths == 1  ? "SCENARIO"
                                                              : "SCENARIO...",
                                .doc = doc};
    input_t input = {options, max_paths, use};
    *options = (task_options_t){.timeout_s = 5,
                                .method = -1,
                                .effort = -1,
                                .paths = calloc((size_t)argc, sizeof *options->paths),
                                .shown = calloc((size_t)argc, sizeof *options->shown)};
    if (options->paths == NULL || options->shown == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        exit(EXIT_FAILED);
    }
    char* const command = argv[0];
    char name[32];
    snprintf(name, sizeof name, "ssv %s", command);
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &input);
    argv[0] = command;
    if (options->scalar != NULL && strcmp(options->scalar, REAL_NAME) != 0 &&
        (options->in_simulation || !options->over_lcm)) {
        hand_over(options->scalar, command, argc, argv);
    }
}

bool task_read(const task_options_t* options, const char* path, scenario_file_t* file, lcm_ssv_task_t* task,
               char* error, size_t error_size) {
    char* const models = task_data_folder(SSV_MODELS_FROM_BIN);
    *file = (scenario_file_t){.tree = NULL};
    if (models == NULL) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    const bool sound = scenario_file_open(file, path, models, task, error, error_size);
    free(models);
    if (!sound) {
        return false;
    }
    task_override(options, &task->scenario);
    return true;
}

void task_override(const task_options_t* options, lcm_ssv_scenario_t* question) {
    if (options->weights_given) {
        question->weight_time_per_s = options->weights[0];
        question->weight_impulse_per_Ns = options->weights[1];
    }
    if (options->method >= 0) {
        question->options.method = options->method;
    }
    if (options->effort >= 0) {
        question->options.effort = options->effort;
    }
    question->options.want_candidates = question->options.want_candidates || options->want_candidates;
    question->options.want_front = question->options.want_front || options->want_front;
}

void task_explain(const task_options_t* options, const char* shown_path, const scenario_file_t* file,
                  const char* reason, char* text, size_t size) {
    const bool of_option = options->weights_given && strncmp(reason, "weight_", strlen("weight_")) == 0;
    char explained[1024];
    if (of_option) {
        snprintf(text, size, "--weights: %s", reason);
        return;
    }
    scenario_file_explain(file, reason, explained, sizeof explained);
    if (strcmp(explained, reason) == 0) {
        snprintf(text, size, "%s: %s", shown_path, reason);
    } else {
        snprintf(text, size, "%s", explained);
    }
}
