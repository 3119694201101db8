/// The daemon's log: lines with time and level on standard error. It never waits for its reader and never floods it: a
/// line that the reader has no room for, or beyond LOG_LINES_PER_S, is counted instead of written, and the next line
/// that goes through says how many were lost.
#ifndef SSV_LOG_H
#define SSV_LOG_H

#include <stdbool.h>
#include <stdint.h>

/// Lines of any level in one second; a burst may be twice as many.
#define LOG_LINES_PER_S 200

typedef enum { LOG_DEBUG, LOG_INFO, LOG_WARN, LOG_ERROR } log_level_t;

/// Whether lines of level LOG_DEBUG are written; they are not at first.
void log_set_verbose(bool verbose);

/// Writes a line, at most 4096 bytes; longer ones are cut. Control characters become '?'.
__attribute__((format(printf, 2, 3))) void log_line(log_level_t level, const char* format, ...);

/// Lines lost so far.
int64_t log_lines_lost(void);

#endif
