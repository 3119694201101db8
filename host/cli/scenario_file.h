/// Reads a scenario file and the model file that it names into the wire type; host/FORMATS.md is for those who write
/// them.
///
/// A file has either the friendly layout, which this lays out as the message, or `scenario:` and, where there is one,
/// `scene:` with the messages themselves, as `ssv scenario` and `ssv plan --format json` write them. Either way it is
/// held to the message types: an unknown,
/// missing or repeated key, or a value of the wrong kind, is refused. Whether the numbers make sense is judged by the
/// planner, except for what never reaches it (the hub).
#ifndef SSV_SCENARIO_FILE_H
#define SSV_SCENARIO_FILE_H

#include "lcm_ssv_task_t.h"
#include "wire/tree.h"

/// What a scenario was read from: its values as the message has them, each with the place that it was written at.
typedef struct {
    tree_memory_t memory;
    const tree_t* tree;  ///< the scenario
    const tree_t* scene; ///< likewise; NULL if the file has none
} scenario_file_t;

/// Reads the task at `path`, "-" being standard input. A model given by name is looked for in `models_dir`; one given
/// by path, as a scene is, relative to the scenario file. Its asker is put aside, and all zero. The file is closed with
/// scenario_file_close in any case.
/// @return true; or false with a sentence in `error` that names file, line and key, and *task in an undefined
/// state.
bool scenario_file_open(scenario_file_t* file, const char* path, const char* models_dir, lcm_ssv_task_t* task,
                        char* error, size_t error_size);

/// The same for the text of such a file, which is not opened.
bool scenario_text_open(scenario_file_t* file, const char* path, const char* text, size_t size, const char* models_dir,
                        lcm_ssv_task_t* task, char* error, size_t error_size);

/// The same for the tree of such a file, which may have been put together from another's: `path` is where a model given
/// by path starts from. *file is empty before.
bool scenario_tree_open(scenario_file_t* file, const char* path, const tree_t* root, const char* models_dir,
                        lcm_ssv_task_t* task, tree_error_t* error);

/// Puts the place in the file before a planner's reason "PATH: sentence", where PATH is the message's.
void scenario_file_explain(const scenario_file_t* file, const char* reason, char* text, size_t size);

void scenario_file_close(scenario_file_t* file);

/// Opens, reads and closes.
bool scenario_file_read(const char* path, const char* models_dir, lcm_ssv_task_t* task, char* error, size_t error_size);

#endif
