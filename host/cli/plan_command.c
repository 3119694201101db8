#include <stdio.h>

#include "ask.h"
#include "commands.h"
#include "output.h"
#include "plan_command.h"
#include "report.h"
#include "ssv/answer.h"
#include "task_options.h"

static const char doc[] =
    "Plans the task of a scenario file: how to fly to the beam, mate, carry it to the hub port and dock, at the least "
    "cost "
    "J = W1 time + W2 impulse."
    "\vExamples:\n"
    "  ssv plan host/scenarios/paper_case.yaml\n"
    "  ssv plan task.yaml --weights 1,0     time alone counts\n"
    "  ssv plan task.yaml --effort best     the least J that the planner knows of\n"
    "  ssv plan task.yaml --method paper    the baseline to compare with\n"
    "  ssv plan task.yaml --candidates      what else was tried, and what it costs\n"
    "  ssv plan task.yaml --format json --output plan.json\n"
    "                                       for scripts and ssv-replay\n"
    "  ssv plan plan.json                   the same question again\n"
    "  ssv plan task.yaml --scalar fixed    as a vehicle computer without floating\n"
    "                                       point would plan it\n"
    "  ssv plan task.yaml --lcm             asks a running ssv-plannerd\n"
    "  ssv plan task.yaml --lcm udpm://239.255.76.67:7667?ttl=1 --timeout 10\n"
    "\n"
    "The method decides what the scenario leaves free: optimal leaves all of it to J, paper goes by the rules of the "
    "paper. "
    "The table says how far above the best possible the plan can be at most. A scenario may name its method and effort "
    "itself.\n"
    "\n"
    "The timeline is feed-forward: with thrusters or masses a little off, a flight of it alone misses, so a vehicle "
    "needs "
    "tracking (ssv fly). `ssv-replay --off` shows by how much.\n"
    "\n"
    "The scenario's model is the name of a file in the models folder (paper, ease) or a path from the scenario file, "
    "mine.yaml or FOLDER/mine.yaml. SCENARIO may also be - for standard input, or what `ssv plan --format json` or "
    "`ssv "
    "scenario` wrote; host/FORMATS.md tells of them all. FILE is replaced in one step by a complete plan; whatever "
    "else comes of it goes to standard output and leaves FILE as it was.\n"
    "\n"
    "Exit codes:\n"
    "   0  plan found\n"
    "   2  the scenario is refused: a file cannot be read, or a key or a value is\n"
    "      wrong; the message names it\n"
    "   3  the scenario is sound, but there is no plan; the answer says why\n"
    "   4  nobody answered over LCM, or not in the scalar asked for, or LCM does\n"
    "      not work here\n"
    "   5  the scenario is sound, but a number on the way to its plan does not fit\n"
    "      the scalar; try --scalar double\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

static int exit_code(const lcm_ssv_plan_t* answer) {
    switch (answer->quote.status) {
        case LCM_SSV_QUOTE_T_STATUS_OK: return EXIT_OK;
        case LCM_SSV_QUOTE_T_STATUS_INFEASIBLE: return EXIT_INFEASIBLE;
        case LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW: return EXIT_OVERFLOW;
        default: return EXIT_INVALID;
    }
}

/// Shows the planner's answer: a plan where the options say, anything else on standard output, and on standard error
/// why it is no plan. @return the exit code.
static int conclude(const task_options_t* options, const lcm_ssv_task_t* question, const lcm_ssv_plan_t* answer) {
    const report_plan_t report = {options->shown[0], question, answer, options->over_lcm};
    const char* const path = answer->quote.status == LCM_SSV_QUOTE_T_STATUS_OK ? options->output_path : NULL;
    const bool written = output_report(path, options->as_json ? report_plan_json : report_plan_table, &report);
    if (answer->quote.status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE) {
        fprintf(stderr, "ssv: %s: no feasible candidate\n", options->shown[0]); // the answer itself says why of each
    } else if (answer->quote.status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        fprintf(stderr, "ssv: %s\n", answer->quote.reason);
    } else if (answer->quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        fprintf(stderr, "ssv: %s: %s\n", options->shown[0], answer->quote.reason);
    }
    return written ? exit_code(answer) : EXIT_FAILED;
}

int plan_show(const task_options_t* options, const scenario_file_t* file, const lcm_ssv_task_t* question,
              const lcm_ssv_plan_t* answer) {
    char reason[1024];
    lcm_ssv_plan_t explained = *answer;
    snprintf(reason, sizeof reason, "%s", answer->quote.reason);
    if (answer->quote.status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        task_explain(options, options->shown[0], file, answer->quote.reason, reason, sizeof reason);
        explained.quote.reason = reason;
    }
    tree_make_harmless(explained.quote.reason); // it may come from the wire, as may the next
    tree_make_harmless(explained.answer.planner.version);
    return conclude(options, question, &explained);
}

int plan_refused(const task_options_t* options, char* reason) {
    const lcm_ssv_plan_t refused = {.quote = {.status = LCM_SSV_QUOTE_T_STATUS_INVALID, .reason = reason}};
    return conclude(options, NULL, &refused);
}

int plan_command(int argc, char** argv) {
    task_options_t options;
    task_options_parse(&options, doc, 1, TASK_ANSWERED, argc, argv);

    char error[1024];
    scenario_file_t file;
    lcm_ssv_task_t question;
    int code = EXIT_NO_ANSWER;
    if (!task_read(&options, options.paths[0], &file, &question, error, sizeof error)) {
        scenario_file_close(&file);
        return plan_refused(&options, error);
    }
    if (!ask_stamp(&question.scenario.asker, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        scenario_file_close(&file);
        return EXIT_FAILED;
    }

    if (!options.over_lcm) {
        static ssv_answer_t answer;
        const lcm_ssv_planner_t planner =
            ssv_planner_identity(question.scenario.asker.asker_id); // asker and planner in one
        ssv_answer(&question, &planner, &answer);
        code = plan_show(&options, &file, &question, &answer.wire);
    } else {
        lcm_ssv_plan_t answer;
        const ask_target_t target = {options.lcm_url, options.scalar, options.timeout_s};
        if (ask_plan(&target, &question, &answer, error, sizeof error)) {
            code = plan_show(&options, &file, &question, &answer);
            lcm_ssv_plan_t_decode_cleanup(&answer);
        } else {
            fprintf(stderr, "ssv: %s\n", error);
        }
    }
    scenario_file_close(&file);
    return code;
}
