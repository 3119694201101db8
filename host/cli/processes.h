/// Programs that stand beside this one, run as its children.
///
/// Nothing of them is left behind, however this program ends: they have a process group of their own, the kernel kills
/// them when their parent dies, and what they read and write are files without a name.
#ifndef SSV_PROCESSES_H
#define SSV_PROCESSES_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

/// A path from the folder of this program.
void process_path(const char* relative, char* path, size_t size);

/// A program that the system has, by its path. @return false if there is none.
bool process_find(const char* name, char* path, size_t size);

/// A new file without a name; -1 with errno set if there is none to be had. A child can inherit it as a number alone.
int process_scratch(void);

/// One child. Its fields are not API.
typedef struct {
    char name[32];
    pid_t pid;       ///< 0 = there is none
    int status;      ///< as waitpid gives it, once it has ended
    int output, log; ///< scratch files of its standard output and standard error; -1 = there are none
} process_t;

/// Starts the program `name` beside this one, or one by its whole path; argv[0] is set. `input` is its standard input,
/// read from its start; -1 for none.
/// @return false with a sentence in `error`.
bool process_start(process_t* process, const char* name, char* const argv[], int input, char* error, size_t error_size);

/// Waits until there is a line on its standard error that has `mark` in it.
/// @param wake_fd  ends the wait when it can be read; -1 for none.
/// @param after    what follows the mark in its line.
/// @return false with a sentence in `error`, if it ends before, or takes too long.
bool process_await(process_t* process, const char* mark, int wake_fd, char* after, size_t after_size, char* error,
                   size_t error_size);

/// Whether it runs.
bool process_runs(process_t* process);

/// Waits until it has ended by itself. @return its exit code, -1 after a signal.
int process_wait(process_t* process);

/// Ends it: asks it to, and after 5 s no longer asks; at once if `kills`. @return its exit code, -1 after a signal.
int process_end(process_t* process, bool kills);

/// All that it wrote, to standard output or to standard error; the caller frees it. NULL if out of memory.
char* process_output(const process_t* process);
char* process_log(const process_t* process);

/// Forgets an ended child and what it wrote; nothing happens if there is none.
void process_close(process_t* process);

#endif
