/// The daemon's log: one line per call on standard error, "2031-05-04T12:00:00.123Z WARN  what happened".
#ifndef SSV_LOG_H
#define SSV_LOG_H

#include <stdbool.h>

typedef enum { LOG_DEBUG, LOG_INFO, LOG_WARN, LOG_ERROR } log_level_t;

/// Whether LOG_DEBUG lines are written; they are not until this says so.
void log_set_verbose(bool verbose);

/// Writes one line, printf style, cut at 4 kB. Control characters in it become '?', so that a message from the wire can
/// neither forge a second line nor reach the terminal.
__attribute__((format(printf, 2, 3))) void log_line(log_level_t level, const char* format, ...);

#endif
