/// What the commands have in common: their options, and how a scenario file becomes a question.
#ifndef SSV_TASK_OPTIONS_H
#define SSV_TASK_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lcm_ssv_task_t.h"
#include "scenario_file.h"
#include "ssv/answer.h"

/// What becomes of the task.
typedef enum { TASK_SHOWN, TASK_ANSWERED, TASK_FLOWN } task_use_t;

typedef struct {
    int num_paths;           ///< [1, the most that the command takes]
    const char** paths;      ///< of scenario files; "-" is standard input. Allocated, this and the next, for good
    char (*shown)[256];      ///< the same for people: nothing in it steers a terminal
    const char* lcm_url;     ///< NULL = LCM's default
    const char* scalar;      ///< "double", "float" or "fixed"; NULL = this program's, or any planner's over LCM
    const char* output_path; ///< NULL = standard output
    const char* conditions;  ///< of a simulated flight, this and the next two: name or path; NULL = none
    const char* seed;        ///< a whole number; NULL = the simulator's
    double rate;             ///< simulated seconds per second; 0 = as fast as it goes
    double weights[2];
    double timeout_s;
    int8_t method, effort; ///< -1 = the file's
    bool over_lcm, weights_given, as_json, want_candidates, want_front, in_simulation, rate_given;
} task_options_t;

/// Parses the command's arguments, argv[0] being its name; --help and wrong arguments end the program. `doc` is the
/// command's part of the help, as of argp; max_paths is 1 or INT_MAX. Where the options ask for the answer of
/// another scalar in process, the program that has it goes on instead of this one.
/// A task that is only shown has the options of the question alone.
void task_options_parse(task_options_t* options, const char* doc, int max_paths, task_use_t use, int argc, char** argv);

/// "W1,W2"; the numbers' ranges are the planner's to judge. @return false if there are not two.
bool task_parse_weights(const char* text, double weights[2]);

/// A folder of data that is installed with this program, by its path from the program's; the caller frees it. NULL if
/// out of memory.
char* task_data_folder(const char* from_bin);

/// Reads a scenario file into `file`, which the caller closes in any case; what the options say counts over what it
/// says. Its asker means nothing yet.
/// @return true; or false with a sentence in `error`.
bool task_read(const task_options_t* options, const char* path, scenario_file_t* file, lcm_ssv_task_t* task,
               char* error, size_t error_size);

/// What the options say of the question counts over what it says.
void task_override(const task_options_t* options, lcm_ssv_scenario_t* question);

/// A planner's reason for refusing the question, as a sentence that names what the user wrote: file and line, or
/// option.
void task_explain(const task_options_t* options, const char* shown_path, const scenario_file_t* file,
                  const char* reason, char* text, size_t size);

#endif
