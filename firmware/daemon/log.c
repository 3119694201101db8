#define _GNU_SOURCE
#include "log.h"

#include <limits.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

/// A pipe that can be written to at all takes this much without waiting.
#define LINE_SIZE PIPE_BUF

static struct {
    bool verbose;
    int64_t lost, lost_reported;
    double allowance; // lines that may be written now
    double filled_s;  // when that was so
} state = {.allowance = 2 * LOG_LINES_PER_S};

void log_set_verbose(bool verbose) { state.verbose = verbose; }

int64_t log_lines_lost(void) { return state.lost; }

static bool take_allowance(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    const double now_s = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
    state.allowance += LOG_LINES_PER_S * (now_s - state.filled_s);
    state.filled_s = now_s;
    if (state.allowance > 2 * LOG_LINES_PER_S) state.allowance = 2 * LOG_LINES_PER_S;
    if (state.allowance < 1) return false;
    state.allowance -= 1;
    return true;
}

// Sockets are told not to wait. What else waits, a pipe or a terminal, says beforehand that it has room. Standard error
// is shared with others, so its own flags stay as they are.
static bool write_line(const char* text, size_t size) {
    const ssize_t sent = send(STDERR_FILENO, text, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) return (size_t)sent == size;
    struct pollfd fd = {.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
    if (poll(&fd, 1, 0) <= 0 || (fd.revents & POLLOUT) == 0) return false;
    return write(STDERR_FILENO, text, size) == (ssize_t)size;
}

/// "2026-11-28T10:00:00.000Z INFO  " and the text, with control characters made harmless. @return its size.
static size_t format_line(char line[LINE_SIZE], log_level_t level, const char* format, va_list args) {
    static const char* const names[] = {"DEBUG", "INFO ", "WARN ", "ERROR"};
    struct timespec now;
    struct tm utc;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &utc);
    char stamp[32];
    strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%S", &utc);
    const int head = snprintf(line, LINE_SIZE, "%s.%03ldZ %s ", stamp, now.tv_nsec / 1000000, names[level]);
    vsnprintf(line + head, (size_t)(LINE_SIZE - head - 1), format, args);
    for (char* c = line; *c != '\0'; c++) {
        if ((unsigned char)*c < ' ' || *c == '\x7f') *c = '?';
    }
    const size_t size = strlen(line);
    line[size] = '\n';
    return size + 1;
}

__attribute__((format(printf, 2, 3))) static bool put(log_level_t level, const char* format, ...) {
    char line[LINE_SIZE];
    va_list args;
    va_start(args, format);
    const size_t size = format_line(line, level, format, args);
    va_end(args);
    return write_line(line, size);
}

void log_line(log_level_t level, const char* format, ...) {
    if (level == LOG_DEBUG && !state.verbose) return;
    if (!take_allowance()) {
        state.lost++;
        return;
    }
    const int64_t unreported = state.lost - state.lost_reported;
    if (unreported > 0 &&
        put(LOG_WARN, "%lld log lines were lost: too many at once, or nobody read them", (long long)unreported)) {
        state.lost_reported = state.lost;
    }
    char line[LINE_SIZE];
    va_list args;
    va_start(args, format);
    const size_t size = format_line(line, level, format, args);
    va_end(args);
    if (!write_line(line, size)) state.lost++;
}
