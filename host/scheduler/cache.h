/// Prices that are kept from one run to the next, by the hash of their question; host/FORMATS.md tells the file's
/// format. A file that is not whole, or not of this planner, is told from one that is.
#ifndef SSV_SCHEDULER_CACHE_H
#define SSV_SCHEDULER_CACHE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct cache cache_t;

/// What a question costs, and where the vehicle ends, in steps of its pose (pricing.h).
typedef struct {
    uint64_t question;
    bool feasible; ///< the rest is 0 if not
    double cost, time_s, impulse_Ns;
    int64_t end[7];
} cache_price_t;

typedef enum {
    CACHE_READ,
    CACHE_FOREIGN, ///< something else than a file of prices
    CACHE_STALE,   ///< prices, but of another planner
    CACHE_BROKEN,
    CACHE_NO_MEMORY
} cache_status_t;

/// @param head  what the prices are of, in a line: planner, arithmetic and what else all questions share. Lent.
/// @return NULL if out of memory.
cache_t* cache_open(const char* head);

/// Adds what the text of a file holds, all or nothing; there must be a zero behind it.
cache_status_t cache_read(cache_t* cache, const char* text, size_t size);

/// @return NULL if it is not there. Valid until the next one is added.
const cache_price_t* cache_find(const cache_t* cache, uint64_t question);

/// Adds one that is not there. @return false if out of memory.
bool cache_add(cache_t* cache, const cache_price_t* price);

int cache_count(const cache_t* cache);

/// Writes the text of a file; the content is the cache.
bool cache_write(FILE* out, const void* content);

void cache_close(cache_t* cache);

#endif
