/// The commands of the program `ssv`. Each gets its own arguments, argv[0] being its name, and returns the exit code.
#ifndef SSV_COMMANDS_H
#define SSV_COMMANDS_H

/// The program's exit codes; a shell script can tell them apart.
enum {
    EXIT_OK = 0,
    EXIT_FAILED = 1,     ///< anything not listed below, e.g. the output cannot be written
    EXIT_INVALID = 2,    ///< the scenario is refused
    EXIT_INFEASIBLE = 3, ///< the scenario is sound, but there is no plan
    EXIT_NO_ANSWER = 4,  ///< nobody answered over LCM
    EXIT_OVERFLOW = 5,   ///< the scenario is sound, but a number does not fit the planner's scalar
    EXIT_MISSED = 6,     ///< flown, but mate or dock did not succeed
    EXIT_ABORTED = 7,    ///< the flight ended before: stopped, strayed, refused, or the vehicle fell silent
    EXIT_TOUCHED = 8,    ///< flown in simulation, and something was touched that was to be kept clear of
    EXIT_USAGE = 64      ///< wrong arguments (sysexits.h, argp)
};

/// `ssv plan`: reads a scenario file, has it planned in process or over LCM, and shows the plan.
int plan_command(int argc, char** argv);

/// `ssv quote`: reads scenario files, has them priced in process or over LCM, and shows the prices side by side.
int quote_command(int argc, char** argv);

/// `ssv scenario`: reads a scenario file and shows the question as understood, every default filled in.
int scenario_command(int argc, char** argv);

/// `ssv fly`: reads a scenario file and has its task flown, in simulation or by a real vehicle; compares with the plan.
int fly_command(int argc, char** argv);

/// `ssv schedule`: reads a structure file and shows in which order its beams are assembled at the least cost.
int schedule_command(int argc, char** argv);

/// `ssv report`: shows a plan or a flight as a page for a browser.
int report_command(int argc, char** argv);

/// `ssv plot`: draws a plan's thrusts, speed and clearance over time.
int plot_command(int argc, char** argv);

/// `ssv log`: turns a recorded log of the bus into tables.
int log_command(int argc, char** argv);

/// `ssv watch`: serves a page that shows what happens on the bus.
int watch_command(int argc, char** argv);

#endif
