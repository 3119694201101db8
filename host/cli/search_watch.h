/// A search for a schedule, watched: how far it is, in one line on a terminal, and when it found what.
#ifndef SSV_SEARCH_WATCH_H
#define SSV_SEARCH_WATCH_H

#include <stdbool.h>

#include "scheduler/pricing.h"

typedef struct {
    const pricing_t* pricing;
    double begun_s, time_limit_s, shown_s;
    double best, bound; ///< so far; INFINITY and 0 if there is none
    double first_s;     ///< after which time there was a schedule
    bool (*gives_up)(void* context);
    void* context;
    bool on_terminal;
    bool stopped; ///< whether it was told to end
} search_watch_t;

/// @param time_limit_s  from now on; 0 for none.
/// @param gives_up      whether the search is to end for another reason, asked again and again.
search_watch_t search_watch_begin(const pricing_t* pricing, double time_limit_s, bool (*gives_up)(void* context),
                                  void* context);

/// What assembly_limits_t calls, the watch being the context.
bool search_watch_must_stop(void* context);
void search_watch_found(void* context, double cost, double lower_bound);

/// Takes the line away.
void search_watch_end(const search_watch_t* watch);

#endif
