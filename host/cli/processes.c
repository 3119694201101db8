#define _GNU_SOURCE
#include "processes.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define LOOK_PERIOD_MS 5
/// How long a child may take to say what is awaited, and to end.
#define PATIENCE_MS 10000
#define ENDING_MS 5000

void process_path(const char* relative, char* path, size_t size) {
    char program[PATH_MAX] = "";
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char* const slash = strrchr(program, '/');
    const int bin_length = slash == NULL ? 0 : (int)(slash + 1 - program);
    snprintf(path, size, "%.*s%s", bin_length, program, relative);
}

bool process_find(const char* name, char* path, size_t size) {
    const char* folders = getenv("PATH");
    while (folders != NULL && *folders != '\0') {
        const size_t length = strcspn(folders, ":");
        const int written = snprintf(path, size, "%.*s/%s", (int)length, folders, name);
        if (length > 0 && *folders == '/' && written > 0 && (size_t)written < size && access(path, X_OK) == 0)
            return true;
        folders += length + (folders[length] == ':');
    }
    return false;
}

int process_scratch(void) { return memfd_create("ssv", MFD_CLOEXEC); }

/// What the child does up to the program. Only calls that are safe after a fork of a process with threads.
__attribute__((noreturn)) static void become(const char* path, char* const argv[], int input, const process_t* process,
                                             pid_t parent) {
    sigset_t none;
    sigemptyset(&none);
    setpgid(0, 0); // what is typed at the terminal is for the parent alone
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || getppid() != parent || dup2(input, STDIN_FILENO) < 0 ||
        dup2(process->output, STDOUT_FILENO) < 0 || dup2(process->log, STDERR_FILENO) < 0 ||
        sigprocmask(SIG_SETMASK, &none, NULL) != 0) {
        _exit(127);
    }
    execv(path, argv);
    _exit(127);
}

bool process_start(process_t* process, const char* name, char* const argv[], int input, char* error,
                   size_t error_size) {
    char path[PATH_MAX];
    const int nothing = process_scratch();
    const pid_t self = getpid();
    *process = (process_t){.output = process_scratch(), .log = process_scratch()};
    const char* const slash = strrchr(name, '/');
    snprintf(process->name, sizeof process->name, "%s", slash == NULL ? name : slash + 1);
    if (name[0] == '/')
        snprintf(path, sizeof path, "%s", name);
    else
        process_path(name, path, sizeof path);
    if (access(path, X_OK) != 0) {
        snprintf(error, error_size, "cannot run %.512s: %s; it belongs beside this program", path, strerror(errno));
    } else if (nothing < 0 || process->output < 0 || process->log < 0 ||
               (input >= 0 && lseek(input, 0, SEEK_SET) != 0) || (process->pid = fork()) < 0) {
        process->pid = 0;
        snprintf(error, error_size, "cannot start %s: %s", name, strerror(errno));
    } else if (process->pid == 0) {
        become(path, argv, input >= 0 ? input : nothing, process, self);
    }
    if (nothing >= 0) close(nothing);
    if (process->pid == 0) process_close(process);
    return process->pid > 0;
}

bool process_runs(process_t* process) {
    if (process->pid > 0 && waitpid(process->pid, &process->status, WNOHANG) == process->pid) process->pid = 0;
    return process->pid > 0;
}

/// All that is in a scratch file, as a text.
static char* contents(int file) {
    struct stat status;
    if (file < 0 || fstat(file, &status) != 0) return strdup("");
    const size_t size = (size_t)status.st_size;
    char* const text = calloc(size + 1, 1);
    if (text != NULL && pread(file, text, size, 0) < 0) *text = '\0';
    return text;
}

char* process_output(const process_t* process) { return contents(process->output); }
char* process_log(const process_t* process) { return contents(process->log); }

/// Copies what follows the mark, if the line that it is in has come to its end.
static bool find_after(const process_t* process, const char* mark, char* after, size_t after_size) {
    char* const log = process_log(process);
    const char* const found = log == NULL ? NULL : strstr(log, mark);
    const char* const end = found == NULL ? NULL : strchr(found, '\n');
    if (end != NULL) {
        const char* const start = found + strlen(mark);
        snprintf(after, after_size, "%.*s", (int)(end - start), start);
    }
    free(log);
    return end != NULL;
}

bool process_await(process_t* process, const char* mark, int wake_fd, char* after, size_t after_size, char* error,
                   size_t error_size) {
    struct pollfd wake = {.fd = wake_fd, .events = POLLIN, .revents = 0};
    for (int waited_ms = 0; waited_ms < PATIENCE_MS; waited_ms += LOOK_PERIOD_MS) {
        const bool runs = process_runs(process); // before the look, so that its last words are seen
        if (find_after(process, mark, after, after_size)) return true;
        if (!runs) {
            snprintf(error, error_size, "%s has ended", process->name);
            return false;
        }
        if (poll(&wake, 1, LOOK_PERIOD_MS) > 0) {
            snprintf(error, error_size, "interrupted");
            return false;
        }
    }
    snprintf(error, error_size, "%s did not say '%s' within %d s", process->name, mark, PATIENCE_MS / 1000);
    return false;
}

int process_wait(process_t* process) {
    if (process->pid > 0) waitpid(process->pid, &process->status, 0);
    process->pid = 0;
    return WIFEXITED(process->status) ? WEXITSTATUS(process->status) : -1;
}

int process_end(process_t* process, bool kills) {
    const struct timespec pause = {0, LOOK_PERIOD_MS * 1000000};
    if (process_runs(process)) kill(process->pid, kills ? SIGKILL : SIGTERM);
    for (int waited_ms = 0; waited_ms < ENDING_MS && process_runs(process); waited_ms += LOOK_PERIOD_MS) {
        nanosleep(&pause, NULL);
    }
    if (process_runs(process)) {
        kill(process->pid, SIGKILL);
        waitpid(process->pid, &process->status, 0);
        process->pid = 0;
    }
    return WIFEXITED(process->status) ? WEXITSTATUS(process->status) : -1;
}

void process_close(process_t* process) {
    if (process->output >= 0) close(process->output);
    if (process->log >= 0) close(process->log);
    process->output = process->log = -1;
}
