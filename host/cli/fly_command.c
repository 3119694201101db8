// `ssv fly`: has a task flown and puts what was flown beside what was planned.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ask.h"
#include "commands.h"
#include "flight.h"
#include "fly_structure.h"
#include "output.h"
#include "plan_command.h"
#include "report.h"
#include "ssv/answer.h"
#include "task_options.h"

static const char doc[] =
    "Plans the task of a scenario file and has it flown: in simulation with --sim, by a real vehicle with --lcm alone. "
    "Shows how the flight gets on, and at its end what was flown beside what was planned, leg by leg."
    "\vExamples:\n"
    "  ssv fly host/scenarios/on_axis.yaml --sim\n"
    "  ssv fly task.yaml --sim --conditions rough --seed 7\n"
    "                                       current, weak thrusters, noise\n"
    "  ssv fly task.yaml --sim --rate 20    slow enough to watch, with lcm-spy, too\n"
    "  ssv fly task.yaml --sim --format json --output flight.json\n"
    "  ssv fly host/structures/ease.yaml --sim\n"
    "                                       a whole structure, beam after beam\n"
    "  ssv fly task.yaml --lcm              MOVES THE REAL VEHICLE of the planner\n"
    "                                       with a --link that is on the bus\n"
    "\n"
    "With --sim a simulated vehicle (ssv-sim) and a planner (ssv-plannerd) are started for this one flight and ended "
    "with it; they talk over the vehicle link as they would in the water, in a time of their own, so the same seed is "
    "the "
    "same flight to the last bit at any rate. Errors at mate and dock are the simulator's truth. Conditions are the "
    "name "
    "of a file in the conditions folder (calm, rough) or a path, mine.yaml or FOLDER/mine.yaml; sim/sil/README.md "
    "tells "
    "of their keys. In disturbed water the scenario should leave the thrusters something to push back with: "
    "thrust_reserve: 0.2.\n"
    "\n"
    "A structure file (host/FORMATS.md) is scheduled first, as by `ssv schedule`, in two minutes at most. Then each "
    "beam "
    "is planned from where the vehicle really is, past what really stands, and flown with a seed of its own, N, N + 1 "
    "and so on. After a flight that fails what is left is scheduled anew, from there; a beam that was carried is let "
    "go where it is. Three such flights in a row end it, with the exit code of the last one.\n"
    "\n"
    "Without --sim, --lcm has the planner fly that hears its vehicle; it must be the only one on the bus that does. "
    "Ctrl-C stops the vehicle: it brakes, then gives no thrust; ssv waits for that and reports. A second Ctrl-C ends "
    "ssv "
    "at once, and leaves a real vehicle to its planner.\n"
    "\n"
    "Exit codes:\n"
    "   0  docked; of a structure: all of its beams\n"
    "   2  the scenario, the structure or the conditions are refused: a file\n"
    "      cannot be read, or a key or a value is wrong; the message names it\n"
    "   3  the scenario or structure is sound, but there is no plan\n"
    "   4  nobody answered over LCM, no planner hears a vehicle, the planner fell\n"
    "      silent, or LCM does not work here\n"
    "   5  the scenario is sound, but a number on the way to its plan does not fit\n"
    "      the scalar\n"
    "   6  missed: mate or dock did not succeed in as many attempts as are made\n"
    "   7  aborted: stopped by Ctrl-C or by another, strayed from the plan, refused\n"
    "      by the planner or the vehicle, or the vehicle fell silent\n"
    "   8  touched, however the flight ended: with --sim, vehicle or beam hit\n"
    "      something that the scenario has around\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

static void warn_of_reserve(const task_options_t* options, const lcm_ssv_scenario_t* task) {
    if (options->conditions == NULL || task->thrust_reserve > 0) return;
    fprintf(stderr,
            "ssv: this plan takes all that the thrusters have, and leaves nothing to push back with; "
            "thrust_reserve: 0.2 in %s would\n",
            options->shown[0]);
}

/// Has the plan flown and shows how it went. @return the exit code.
static int fly(const task_options_t* options, lcm_ssv_task_t* question, const scenario_file_t* file,
               const lcm_ssv_plan_t* plan) {
    static flight_result_t result;
    const report_plan_t predicted = {options->shown[0], question, plan, false};
    flight_signals_t signals;
    warn_of_reserve(options, &question->scenario);
    if (!options->in_simulation) fprintf(stderr, "ssv: this moves a real vehicle; Ctrl-C stops it\n");
    if (!flight_take_signals(&signals)) return EXIT_FAILED;
    int code = flight_fly(options, &predicted, question, &signals, &result);
    if (result.is_flown) {
        const report_flight_t report = flight_report(options, &predicted, &result);
        const bool written =
            output_report(options->output_path, options->as_json ? report_flight_json : report_flight_table, &report);
        if (!written) code = EXIT_FAILED;
    } else if (code == EXIT_INFEASIBLE) {
        code = plan_show(options, file, question, &result.plan);
    }
    flight_close(&result);
    return code;
}

/// Reads the structure and has it assembled. @return the exit code.
static int assemble(const task_options_t* options) {
    static structure_t structure;
    char error[1024] = "out of memory";
    char* const models = task_data_folder(SSV_MODELS_FROM_BIN);
    if (!options->in_simulation) {
        fprintf(stderr, "ssv: %s: a structure is flown in simulation alone; --sim does\n", options->shown[0]);
        free(models);
        return EXIT_USAGE;
    }
    const bool sound = models != NULL && structure_read(&structure, options->paths[0], models, error, sizeof error);
    free(models);
    if (!sound) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    task_override(options, &structure.task);
    warn_of_reserve(options, &structure.task);
    return fly_structure(options, &structure);
}

int fly_command(int argc, char** argv) {
    task_options_t options;
    task_options_parse(&options, doc, 1, TASK_FLOWN, argc, argv);
    if (structure_is_meant(options.paths[0])) return assemble(&options);

    char error[1024];
    scenario_file_t file;
    lcm_ssv_task_t question;
    int code = EXIT_FAILED;
    if (!task_read(&options, options.paths[0], &file, &question, error, sizeof error)) {
        code = plan_refused(&options, error);
    } else if (!ask_stamp(&question.scenario.asker, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
    } else {
        static ssv_answer_t answer;
        const lcm_ssv_planner_t planner = ssv_planner_identity(question.scenario.asker.asker_id);
        ssv_answer(&question, &planner, &answer);
        code = answer.wire.quote.status == LCM_SSV_QUOTE_T_STATUS_OK
                   ? fly(&options, &question, &file, &answer.wire)
                   : plan_show(&options, &file, &question, &answer.wire);
    }
    scenario_file_close(&file);
    return code;
}
