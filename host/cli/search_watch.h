/// A search for a schedule, watched: how far it is, in one line on a terminal, and when it found what.
#ifndef SSV_SEARCH_WATCH_H
#define SSV_SEARCH_WATCH_H

#include <stdbool.h>

#include "scheduler/pricing.h"

typedef struct {
    const pricing_t* pricing;
    double begun_s, shown_s;
    double best, bound; ///< so far; INFINITY and 0 if there is none
    double first_s;     ///< after which time there was a schedule
    /// Whether the search is to end, asked again and again; NULL for never. Needs a time limit.
    bool (*gives_up)(void* context);
    void* context;
    bool on_terminal;
} search_watch_t;

search_watch_t search_watch_begin(const pricing_t* pricing);

/// What assembly_limits_t calls, the watch being its context.
double search_watch_clock_s(void* watch);
void search_watch_found(void* watch, double cost, double lower_bound);

/// Takes the line away.
void search_watch_end(const search_watch_t* watch);

#endif
