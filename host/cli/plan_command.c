#define _DEFAULT_SOURCE
#include "plan_command.h"

#include <argp.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "ask.h"
#include "output.h"
#include "report.h"
#include "scenario_file.h"
#include "ssv/answer.h"

static const char doc[] =
    "Plans the task of a scenario file: how to fly to the beam, mate, carry it to the hub port and dock, at the least cost "
    "J = W1 time + W2 impulse."
    "\vExamples:\n"
    "  ssv plan host/scenarios/paper_case.yaml\n"
    "  ssv plan task.yaml --weights 1,0     time alone counts\n"
    "  ssv plan task.yaml --method optimal --effort best\n"
    "                                       the least J that the planner knows of\n"
    "  ssv plan task.yaml --method paper    the baseline to compare with\n"
    "  ssv plan task.yaml --format json --output plan.json\n"
    "                                       for scripts and ssv-replay\n"
    "  ssv plan task.yaml --lcm             asks a running ssv-plannerd\n"
    "  ssv plan task.yaml --lcm udpm://239.255.76.67:7667?ttl=1 --timeout 10\n"
    "\n"
    "The method decides what the scenario leaves free: optimal leaves all of it to J, paper goes by the rules of the paper. "
    "The table says how far above the best possible the plan can be at most. A scenario may name its method and effort "
    "itself.\n"
    "\n"
    "The scenario's model is the name of a file in the models folder (paper, ease) or a path from the scenario file, "
    "mine.yaml or FOLDER/mine.yaml. FILE is replaced in one step when the answer is complete, or left as it was.\n"
    "\n"
    "Exit codes:\n"
    "   0  plan found\n"
    "   2  the scenario is refused: a file cannot be read, or a key or a value is\n"
    "      wrong; the message names it\n"
    "   3  the scenario is sound, but there is no plan; the answer says why\n"
    "   4  nobody answered over LCM, or LCM does not work here\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

enum { KEY_LCM = 256, KEY_WEIGHTS, KEY_METHOD, KEY_EFFORT, KEY_FORMAT, KEY_OUTPUT, KEY_TIMEOUT };

static const struct argp_option options[] = {
    {"lcm", KEY_LCM, "URL", OPTION_ARG_OPTIONAL, "Ask a running ssv-plannerd over LCM, instead of planning in process", 0},
    {"weights", KEY_WEIGHTS, "W1,W2", 0, "Weights of time [1/s] and impulse [1/(N s)] instead of the file's", 0},
    {"method", KEY_METHOD, "optimal|paper", 0, "What decides the free choices, instead of the file's (default "
     SCENARIO_METHOD_DEFAULT ")", 0},
    {"effort", KEY_EFFORT, "quick|best", 0, "How much method optimal tries, instead of the file's (default "
     SCENARIO_EFFORT_DEFAULT ")", 0},
    {"format", KEY_FORMAT, "table|json", 0, "For people (default) or for programs", 0},
    {"output", KEY_OUTPUT, "FILE", 0, "Write there instead of to standard output", 0},
    {"timeout", KEY_TIMEOUT, "S", 0, "How long to wait for an answer over LCM [s] (default 5)", 0},
    {0},
};

typedef struct {
    const char* scenario_path;
    const char* lcm_url;          ///< NULL = LCM's default
    const char* output_path;      ///< NULL = standard output
    double weights[2];
    double timeout_s;
    int8_t method, effort;        ///< -1 = the file's
    bool over_lcm, weights_given, as_json;
} arguments_t;

/// "W1,W2"; the numbers' ranges are the planner's to judge.
static bool parse_weights(const char* text, double weights[2]) {
    const char* const comma = strchr(text, ',');
    char first[64];
    if (comma == NULL || (size_t)(comma - text) >= sizeof first) {
        return false;
    }
    snprintf(first, sizeof first, "%.*s", (int)(comma - text), text);
    return number_parse(first, &weights[0]) && number_parse(comma + 1, &weights[1]);
}

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* arguments = state->input;
    switch (key) {
    case KEY_LCM:
        arguments->over_lcm = true;
        arguments->lcm_url = argument;
        if (argument == NULL && state->next < state->argc && strstr(state->argv[state->next], "://") != NULL) {
            arguments->lcm_url = state->argv[state->next++];  // argp leaves "--lcm URL" without a "=" to us
        }
        return 0;
    case KEY_WEIGHTS:
        if (!parse_weights(argument, arguments->weights)) {
            argp_error(state, "--weights %s: not two numbers with a comma between, e.g. 1,0.5", argument);
        }
        arguments->weights_given = true;
        return 0;
    case KEY_METHOD:
        arguments->method = word_find(argument, scenario_methods, 2);
        if (arguments->method < 0) {
            argp_error(state, "--method %s: there are optimal and paper", argument);
        }
        return 0;
    case KEY_EFFORT:
        arguments->effort = word_find(argument, scenario_efforts, 2);
        if (arguments->effort < 0) {
            argp_error(state, "--effort %s: there are quick and best", argument);
        }
        return 0;
    case KEY_FORMAT:
        arguments->as_json = strcmp(argument, "json") == 0;
        if (!arguments->as_json && strcmp(argument, "table") != 0) {
            argp_error(state, "--format %s: there are table and json", argument);
        }
        return 0;
    case KEY_OUTPUT:
        arguments->output_path = argument;
        return 0;
    case KEY_TIMEOUT:
        if (!number_parse(argument, &arguments->timeout_s) || !(arguments->timeout_s > 0 && arguments->timeout_s <= 3600)) {
            argp_error(state, "--timeout %s: not a number of seconds in (0, 3600]", argument);
        }
        return 0;
    case ARGP_KEY_ARG:
        if (state->arg_num > 0) {
            argp_error(state, "one scenario at a time, but there is also '%s'", argument);
        }
        arguments->scenario_path = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which scenario file?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/// The folder of the models, at the same place beside the program in the build tree and where it is installed; the caller
/// frees it. NULL if out of memory.
static char* find_models(void) {
    char program[PATH_MAX] = "";
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char* const slash = strrchr(program, '/');
    const int bin_length = slash == NULL ? 0 : (int)(slash + 1 - program);
    char joined[PATH_MAX + sizeof SSV_MODELS_FROM_BIN];
    snprintf(joined, sizeof joined, "%.*s" SSV_MODELS_FROM_BIN, bin_length, program);
    char* const resolved = realpath(joined, NULL);
    return resolved != NULL ? resolved : strdup(joined);
}

/// The request id is unique per run: microseconds of the clock, and the process, for two that start within the same one.
/// Below 2^53, so that JSON readers with nothing but doubles keep it whole.
static void stamp(lcm_ssv_scenario_t* question) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    question->epoch_us = (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
    question->request_id = question->epoch_us * 4 + getpid() % 4;
}

static const char* title_of(const char* path) {
    const char* const slash = strrchr(path, '/');
    return slash == NULL ? path : slash + 1;
}

/// Shows the answer as asked for. @return the exit code.
static int show(const arguments_t* arguments, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* answer) {
    char* text = NULL;
    size_t size = 0;
    FILE* memory = open_memstream(&text, &size);
    if (memory == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        return EXIT_FAILED;
    }
    bool complete = true;
    if (arguments->as_json) {
        complete = report_json(memory, question, answer);
    } else {
        report_table(memory, title_of(arguments->scenario_path), question, answer);
    }
    complete = fclose(memory) == 0 && complete;
    if (!complete) {
        fprintf(stderr, "ssv: the answer holds a number that is not finite, or memory ran out\n");
    }
    const bool written = complete && (size == 0 || output_write(arguments->output_path, text, size));
    free(text);
    if (!written) {
        return EXIT_FAILED;
    }
    switch (answer->status) {
    case LCM_SSV_PLAN_T_STATUS_OK:
        return EXIT_OK;
    case LCM_SSV_PLAN_T_STATUS_INFEASIBLE:
        return EXIT_INFEASIBLE;
    default:
        return EXIT_INVALID;
    }
}

/// Shows the planner's answer, and on standard error why it is no plan.
static int conclude(const arguments_t* arguments, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* answer) {
    const int code = show(arguments, question, answer);
    if (answer->status == LCM_SSV_PLAN_T_STATUS_INFEASIBLE) {
        fprintf(stderr, "ssv: %s: no feasible candidate\n", arguments->scenario_path); // the answer itself says why of each
    } else if (answer->status != LCM_SSV_PLAN_T_STATUS_OK) {
        fprintf(stderr, "ssv: %s: %s\n", arguments->scenario_path, answer->reason);
    }
    return code;
}

int plan_command(int argc, char** argv) {
    static const struct argp parser = {.options = options, .parser = parse_option, .args_doc = "SCENARIO.yaml", .doc = doc};
    arguments_t arguments = {.timeout_s = 5, .method = -1, .effort = -1};
    argv[0] = "ssv plan";
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);

    char error[1024];
    lcm_ssv_scenario_t question;
    char* const models = find_models();
    if (models == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        return EXIT_FAILED;
    }
    const bool sound = scenario_file_read(arguments.scenario_path, models, &question, error, sizeof error);
    free(models);
    if (!sound) {
        const lcm_ssv_plan_t refused = {.status = LCM_SSV_PLAN_T_STATUS_INVALID, .reason = error};
        const int code = show(&arguments, &question, &refused);
        fprintf(stderr, "ssv: %s\n", error);
        return code;
    }
    if (arguments.weights_given) {
        question.weight_time_per_s = arguments.weights[0];
        question.weight_impulse_per_Ns = arguments.weights[1];
    }
    if (arguments.method >= 0) {
        question.options.method = arguments.method;
    }
    if (arguments.effort >= 0) {
        question.options.effort = arguments.effort;
    }
    stamp(&question);

    if (!arguments.over_lcm) {
        static ssv_answer_t answer;
        ssv_answer(&question, &answer);
        return conclude(&arguments, &question, &answer.wire);
    }
    lcm_ssv_plan_t answer;
    if (!ask(arguments.lcm_url, arguments.timeout_s, &question, &answer, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_NO_ANSWER;
    }
    const int code = conclude(&arguments, &question, &answer);
    lcm_ssv_plan_t_decode_cleanup(&answer);
    return code;
}
