#define _POSIX_C_SOURCE 200809L
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "ask.h"
#include "commands.h"
#include "output.h"
#include "report.h"
#include "ssv/answer.h"
#include "task_options.h"
#include "wire/message.h"

static const char doc[] =
    "Prices any number of tasks, each described by a scenario file, side by side: J = W1 time + W2 impulse, its parts, "
    "a "
    "price "
    "that no plan can undercut, and where the vehicle mates. A quote is what `ssv plan` would cost, without the plan."
    "\vExamples:\n"
    "  ssv quote host/scenarios/*.yaml\n"
    "  ssv quote host/scenarios/*.yaml --lcm\n"
    "                                       asks all running ssv-plannerd, which share\n"
    "                                       the work\n"
    "  ssv quote task.yaml --candidates     also every contact and height\n"
    "  ssv quote task.yaml --front --format json\n"
    "                                       also what time and impulse can be\n"
    "                                       traded for: change weights afterwards\n"
    "                                       without asking again\n"
    "\n"
    "The column \"gap %\" says how far above the best possible the price can be at most. A task that is refused or has "
    "no "
    "plan leaves the others alone. Scenario files are as for `ssv plan`. FILE is left as it was if a task is refused; "
    "the answer then goes to standard output.\n"
    "\n"
    "Exit codes, of the worst task:\n"
    "   0  every task has a price\n"
    "   2  a scenario is refused: a file cannot be read, or a key or a value is\n"
    "      wrong; the message names it\n"
    "   3  every scenario is sound, but for one there is no plan; the answer\n"
    "      says why\n"
    "   4  nobody answered over LCM, or not in the scalar asked for, or LCM does\n"
    "      not work here\n"
    "   5  every scenario is sound, but a number on the way to a price does not fit\n"
    "      the scalar; try --scalar double\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

/// One scenario file and what comes of it.
typedef struct {
    lcm_ssv_task_t question;
    scenario_file_t file;
    lcm_ssv_quote_t refused; ///< of a file that is no scenario, or that the planner refuses
    char error[1024];        ///< likewise: why, in words of the file
    int number;              ///< in the batch; -1 for a file that is no scenario
} task_t;

/// The quote of a task, with a refusal in words of the file.
static const lcm_ssv_quote_t* quote_of(const task_options_t* options, int i, task_t* task, lcm_ssv_quote_t* quotes) {
    lcm_ssv_quote_t* quote = task->number < 0 ? &task->refused : &quotes[task->number];
    tree_make_harmless(quote->reason); // it may come from the wire
    if (task->number >= 0 && quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        task_explain(options, options->shown[i], &task->file, quote->reason, task->error, sizeof task->error);
        task->refused = *quote;
        task->refused.reason = task->error;
        quote = &task->refused;
    }
    return quote;
}

/// On standard error why a price is missing. @return the exit code of this one.
static int tell(const task_options_t* options, int i, const lcm_ssv_quote_t* quote) {
    switch (quote->status) {
        case LCM_SSV_QUOTE_T_STATUS_OK: return EXIT_OK;
        case LCM_SSV_QUOTE_T_STATUS_INFEASIBLE:
            fprintf(stderr, "ssv: %s: no feasible candidate\n",
                    options->shown[i]); // the answer itself says why of each
            return EXIT_INFEASIBLE;
        case LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW:
            fprintf(stderr, "ssv: %s: %s\n", options->shown[i], quote->reason);
            return EXIT_OVERFLOW;
        default: fprintf(stderr, "ssv: %s\n", quote->reason); return EXIT_INVALID;
    }
}

/// Which of two exit codes is that of the worse task.
static int worse(int a, int b) {
    static const int by_severity[] = {EXIT_INVALID, EXIT_OVERFLOW, EXIT_INFEASIBLE};
    for (size_t i = 0; i < sizeof by_severity / sizeof by_severity[0]; i++) {
        if (a == by_severity[i] || b == by_severity[i]) {
            return by_severity[i];
        }
    }
    return EXIT_OK;
}

/// Shows the prices as asked for; a file is left alone if a task is refused. @return the exit code.
static int conclude(const task_options_t* options, task_t* tasks, lcm_ssv_quote_t* quotes) {
    report_quotes_t report = {options->num_paths, calloc((size_t)options->num_paths, sizeof *report.row)};
    int code = EXIT_OK;
    bool refused = false;
    if (report.row == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        return EXIT_FAILED;
    }
    for (int i = 0; i < options->num_paths; i++) {
        report.row[i] =
            (report_quote_t){options->shown[i], &tasks[i].question, quote_of(options, i, &tasks[i], quotes)};
        refused = refused || report.row[i].quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID;
    }
    const bool written = output_report(refused ? NULL : options->output_path,
                                       options->as_json ? report_quotes_json : report_quotes_table, &report);
    for (int i = 0; i < options->num_paths; i++) {
        code = worse(code, tell(options, i, report.row[i].quote));
    }
    free(report.row);
    return written ? code : EXIT_FAILED;
}

/// Prices in process. @return false if out of memory.
static bool price_here(const lcm_ssv_asker_t* asker, lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes) {
    static ssv_batch_answer_t answer;
    const lcm_ssv_planner_t planner = ssv_planner_identity(asker->asker_id); // asker and planner in one
    for (int i = 0; i < count; i++) {
        const lcm_ssv_scenario_batch_t batch = {
            .asker = *asker, .num_scenarios = 1, .scene = tasks[i].scene, .scenarios = &tasks[i].scenario};
        ssv_answer_batch(&batch, 0, &planner, &answer); // nobody checks the hash of a question that was not sent
        lcm_ssv_quote_t* const copy = lcm_ssv_quote_t_copy(&answer.wire.quotes[0]);
        if (copy == NULL) return false;
        quotes[i] = *copy;
        free(copy);
    }
    return true;
}

/// On a terminal, how far a long question is.
static void show_progress(int priced, int count, void* context) {
    (void)context;
    if (count > SSV_MAX_BATCH && isatty(STDERR_FILENO)) {
        fprintf(stderr, "ssv: %d of %d priced%s", priced, count, priced == count ? "\n" : "\r");
    }
}

/// Reads the files; those that are scenarios come one after the other. @return how many there are.
static int read_tasks(const task_options_t* options, const lcm_ssv_asker_t* asker, task_t* tasks,
                      lcm_ssv_task_t* questions) {
    int count = 0;
    for (int i = 0; i < options->num_paths; i++) {
        task_t* task = &tasks[i];
        if (!task_read(options, options->paths[i], &task->file, &task->question, task->error, sizeof task->error)) {
            task->refused = (lcm_ssv_quote_t){.status = LCM_SSV_QUOTE_T_STATUS_INVALID, .reason = task->error};
            task->number = -1;
            continue;
        }
        task->question.scenario.asker = *asker;
        task->number = count;
        questions[count++] = task->question;
    }
    return count;
}

int quote_command(int argc, char** argv) {
    task_options_t options;
    char error[1024];
    lcm_ssv_asker_t asker;
    task_options_parse(&options, doc, INT_MAX, TASK_ANSWERED, argc, argv);
    const size_t most = (size_t)options.num_paths;
    task_t* const tasks = calloc(most, sizeof *tasks);
    lcm_ssv_task_t* const questions = calloc(most, sizeof *questions);
    lcm_ssv_quote_t* const quotes = calloc(most, sizeof *quotes);
    if (tasks == NULL || questions == NULL || quotes == NULL || !ask_stamp(&asker, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", tasks == NULL || questions == NULL || quotes == NULL ? "out of memory" : error);
        free(tasks);
        free(questions);
        free(quotes);
        return EXIT_FAILED;
    }
    const int count = read_tasks(&options, &asker, tasks, questions);
    int code = EXIT_OK;
    if (options.over_lcm && count > 0) {
        const ask_target_t target = {options.lcm_url, options.scalar, options.timeout_s};
        if (!ask_quotes(&target, questions, count, quotes, show_progress, NULL, error, sizeof error)) {
            fprintf(stderr, "ssv: %s\n", error);
            code = EXIT_NO_ANSWER;
        }
    } else if (!price_here(&asker, questions, count, quotes)) {
        fprintf(stderr, "ssv: out of memory\n");
        code = EXIT_FAILED;
    }
    if (code == EXIT_OK) code = conclude(&options, tasks, quotes);
    for (int i = 0; i < options.num_paths; i++) {
        scenario_file_close(&tasks[i].file);
        wire_clear("quote_t", &quotes[i]);
    }
    free(tasks);
    free(questions);
    free(quotes);
    return code;
}
