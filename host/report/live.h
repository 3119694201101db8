/// What happens on the bus, as the page shows it while it happens: the plan that was made last, the flight that is
/// under way, and the tasks of the same assembly that were docked before. Fed with messages one by one, of which none
/// is trusted: bytes are looked at first, a plan must answer a question that was heard.
#ifndef SSV_LIVE_H
#define SSV_LIVE_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct live live_t;

/// @return NULL if out of memory.
live_t* live_begin(void);
void live_end(live_t* live);

/// Takes a message from a channel at a time by any clock that goes on. @return what the page is to be told of it, which
/// the caller frees; NULL if nothing: the message is none, or changes nothing.
json_t* live_take(live_t* live, const char* channel, const void* data, size_t size, double now_s);

/// All that the page must know to go on from here, likewise.
json_t* live_snapshot(const live_t* live);

/// How many messages were taken, and how many were none of what their channel is for.
void live_counts(const live_t* live, long* taken, long* refused);

#endif
