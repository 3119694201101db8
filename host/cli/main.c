#include <argp.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "ssv/planner.h"

const char* argp_program_version = "ssv " SSV_VERSION " (" REAL_NAME ")";

static const struct {
    const char* name;
    int (*run)(int argc, char** argv);
} commands[] = {
    {"plan", plan_command},         {"quote", quote_command},       {"fly", fly_command},
    {"scenario", scenario_command}, {"schedule", schedule_command}, {"report", report_command},
    {"plot", plot_command},         {"log", log_command},           {"watch", watch_command},
};

static const char doc[] =
    "Asks the onboard trajectory planner what it costs to fly to a beam and carry it to a hub port, and which thrusts "
    "do it."
    "\vCommands:\n"
    "  plan      plan one task, described by a scenario file\n"
    "  quote     what tasks cost, side by side, without their plans\n"
    "  fly       have a task flown, in simulation or by a real vehicle\n"
    "  scenario  the question as understood, every default filled in\n"
    "  schedule  which beam goes where, in which order, to assemble a structure\n"
    "  report    a plan or a flight as a picture that opens in any browser\n"
    "  plot      a plan's thrusts, speed and clearance, for paper or in the terminal\n"
    "  log       a recorded log of the bus as tables\n"
    "  watch     what happens on the bus, in a browser, while it happens\n"
    "\n"
    "`ssv COMMAND --help` tells about a command.";

typedef struct {
    int command_at; ///< index of the command's name in argv
} arguments_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* arguments = state->input;
    switch (key) {
        case ARGP_KEY_ARG:
            arguments->command_at = state->next - 1;
            state->next = state->argc; // the rest is the command's
            (void)argument;
            return 0;
        case ARGP_KEY_NO_ARGS:
            argp_error(state,
                       "which command? There are: plan, quote, fly, scenario, schedule, report, plot, log, watch");
            return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

int main(int argc, char** argv) {
    static const struct argp parser = {.parser = parse_option, .args_doc = "COMMAND [ARGUMENT...]", .doc = doc};
    arguments_t arguments = {0};
    argp_parse(&parser, argc, argv, ARGP_IN_ORDER, NULL, &arguments);

    char** const rest = argv + arguments.command_at;
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        if (strcmp(rest[0], commands[i].name) == 0) {
            return commands[i].run(argc - arguments.command_at, rest);
        }
    }
    fprintf(stderr,
            "ssv: there is no command '%s'. There are: plan, quote, fly, scenario, schedule, report, plot, log, watch\n"
            "Try `ssv --help' for more "
            "information.\n",
            rest[0]);
    return EXIT_USAGE;
}
