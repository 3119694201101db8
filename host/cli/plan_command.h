/// `ssv plan`: reads a scenario file, has it planned in process or over LCM, and shows the answer.
#ifndef SSV_PLAN_COMMAND_H
#define SSV_PLAN_COMMAND_H

/// The program's exit codes; a shell script can tell them apart.
enum {
    EXIT_OK = 0,
    EXIT_FAILED = 1,              ///< anything not listed below, e.g. the output cannot be written
    EXIT_INVALID = 2,             ///< the scenario is refused
    EXIT_INFEASIBLE = 3,          ///< the scenario is sound, but there is no plan
    EXIT_NO_ANSWER = 4,           ///< nobody answered over LCM
    EXIT_USAGE = 64               ///< wrong arguments (sysexits.h, argp)
};

/// Runs the command; argv[0] is its name. @return the exit code.
int plan_command(int argc, char** argv);

#endif
