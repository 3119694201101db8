#include <stdio.h>

#include "ask.h"
#include "commands.h"
#include "output.h"
#include "report.h"
#include "ssv/answer.h"
#include "task_options.h"

static const char doc[] =
    "Prices up to 16 tasks, each described by a scenario file, side by side: J = W1 time + W2 impulse, its parts, a "
    "price "
    "that no plan can undercut, and where the vehicle mates. A quote is what `ssv plan` would cost, without the plan."
    "\vExamples:\n"
    "  ssv quote host/scenarios/*.yaml\n"
    "  ssv quote host/scenarios/*.yaml --lcm\n"
    "                                       asks a running ssv-plannerd\n"
    "  ssv quote task.yaml --candidates     also every contact and height\n"
    "  ssv quote task.yaml --front --format json\n"
    "                                       also what time and impulse can be\n"
    "                                       traded for: change weights afterwards\n"
    "                                       without asking again\n"
    "\n"
    "The column \"gap %\" says how far above the best possible the price can be at most. A task that is refused or has "
    "no "
    "plan leaves the others alone. Scenario files and FILE are as for `ssv plan`.\n"
    "\n"
    "Exit codes, of the worst task:\n"
    "   0  every task has a price\n"
    "   2  a scenario is refused: a file cannot be read, or a key or a value is\n"
    "      wrong; the message names it\n"
    "   3  every scenario is sound, but for one there is no plan; the answer\n"
    "      says why\n"
    "   4  nobody answered over LCM, or not in the scalar asked for, or LCM does not\n"
    "      work here\n"
    "   5  every scenario is sound, but a number on the way to a price does not fit\n"
    "      the scalar; try --scalar double\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

/// One scenario file and what comes of it.
typedef struct {
    lcm_ssv_scenario_t question;
    lcm_ssv_quote_t refused; ///< of a file that is no scenario
    char error[1024];        ///< likewise: why
    int number;              ///< in the batch; -1 for a file that is no scenario
} task_t;

/// Shows the prices as asked for, and on standard error why one is missing. @return the exit code.
static int conclude(const task_options_t* options, const task_t* tasks, const lcm_ssv_quote_batch_t* answer) {
    static report_quotes_t report;
    int code = EXIT_OK;
    report.count = options->num_paths;
    for (int i = 0; i < options->num_paths; i++) {
        const task_t* task = &tasks[i];
        const lcm_ssv_quote_t* quote = task->number < 0 ? &task->refused : &answer->quotes[task->number];
        report.row[i] = (report_quote_t){options->paths[i], &task->question, quote};
        if (quote->status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE) {
            code = code == EXIT_OK ? EXIT_INFEASIBLE : code;
        } else if (quote->status == LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW) {
            code = code == EXIT_INVALID ? code : EXIT_OVERFLOW;
        } else if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
            code = EXIT_INVALID;
        }
    }
    if (!output_report(options->output_path, options->as_json ? report_quotes_json : report_quotes_table, &report)) {
        return EXIT_FAILED;
    }
    for (int i = 0; i < options->num_paths; i++) {
        const lcm_ssv_quote_t* quote = report.row[i].quote;
        if (tasks[i].number < 0) {
            fprintf(stderr, "ssv: %s\n", tasks[i].error);
        } else if (quote->status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE) {
            fprintf(stderr, "ssv: %s: no feasible candidate\n",
                    options->paths[i]); // the answer itself says why of each
        } else if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
            fprintf(stderr, "ssv: %s: %s\n", options->paths[i], quote->reason);
        }
    }
    return code;
}

int quote_command(int argc, char** argv) {
    static task_t tasks[SSV_MAX_BATCH];
    static lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH];
    task_options_t options;
    task_options_parse(&options, doc, SSV_MAX_BATCH, argc, argv);

    lcm_ssv_scenario_batch_t batch = {.scenarios = scenarios};
    task_stamp(&batch.request_id, &batch.epoch_us);
    for (int i = 0; i < options.num_paths; i++) {
        task_t* task = &tasks[i];
        if (!task_read(&options, options.paths[i], &task->question, task->error, sizeof task->error)) {
            task->refused = (lcm_ssv_quote_t){.status = LCM_SSV_QUOTE_T_STATUS_INVALID, .reason = task->error};
            task->number = -1;
            continue;
        }
        task->question.request_id = batch.request_id;
        task->question.epoch_us = batch.epoch_us;
        task->number = batch.num_scenarios;
        scenarios[batch.num_scenarios++] = task->question;
    }

    if (!options.over_lcm || batch.num_scenarios == 0) {
        static ssv_batch_answer_t answer;
        ssv_answer_batch(&batch, &answer);
        return conclude(&options, tasks, &answer.wire);
    }
    char error[1024];
    lcm_ssv_quote_batch_t answer;
    if (!ask_quotes(options.lcm_url, options.scalar, options.timeout_s, &batch, &answer, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_NO_ANSWER;
    }
    const int code = conclude(&options, tasks, &answer);
    lcm_ssv_quote_batch_t_decode_cleanup(&answer);
    return code;
}
