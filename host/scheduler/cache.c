// A table of prices by question, and its text.
#define _GNU_SOURCE
#include "cache.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_WORDS "ssv prices 1: "
#define LAST_WORD "end "

struct cache {
    const char* head;
    cache_price_t* prices; ///< where they hash to, or the next place that is free; question 0 is none
    size_t room;           ///< a power of two, or 0
    int count;
};

// ---- The table ------------------------------------------------------------------------------------------------------

cache_t* cache_open(const char* head) {
    cache_t* const cache = calloc(1, sizeof *cache);
    if (cache != NULL) cache->head = head;
    return cache;
}

static cache_price_t* place_of(cache_price_t* prices, size_t room, uint64_t question) {
    size_t i = (size_t)(question * 0x9e3779b97f4a7c15u >> 20) & (room - 1);
    while (prices[i].question != 0 && prices[i].question != question) i = (i + 1) & (room - 1);
    return &prices[i];
}

const cache_price_t* cache_find(const cache_t* cache, uint64_t question) {
    if (cache->room == 0 || question == 0) return NULL;
    const cache_price_t* const place = place_of(cache->prices, cache->room, question);
    return place->question == 0 ? NULL : place;
}

static bool make_room(cache_t* cache) {
    const size_t room = cache->room == 0 ? 1024 : 2 * cache->room;
    if (2 * ((size_t)cache->count + 1) <= cache->room) return true;
    cache_price_t* const prices = calloc(room, sizeof *prices);
    if (prices == NULL) return false;
    for (size_t i = 0; i < cache->room; i++) {
        if (cache->prices[i].question != 0) *place_of(prices, room, cache->prices[i].question) = cache->prices[i];
    }
    free(cache->prices);
    cache->prices = prices;
    cache->room = room;
    return true;
}

bool cache_add(cache_t* cache, const cache_price_t* price) {
    if (price->question == 0) return true; // nobody has asked this
    if (!make_room(cache)) return false;
    cache_price_t* const place = place_of(cache->prices, cache->room, price->question);
    cache->count += place->question == 0;
    *place = *price;
    return true;
}

int cache_count(const cache_t* cache) { return cache->count; }

void cache_close(cache_t* cache) {
    if (cache == NULL) return;
    free(cache->prices);
    free(cache);
}

// ---- The text -------------------------------------------------------------------------------------------------------

static uint64_t sum_of(const char* text, size_t size) {
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < size; i++) sum = (sum ^ (unsigned char)text[i]) * 1099511628211u;
    return sum;
}

static int by_question(const void* a, const void* b) {
    const uint64_t one = ((const cache_price_t*)a)->question, other = ((const cache_price_t*)b)->question;
    return (one > other) - (one < other);
}

static void write_price(FILE* out, const cache_price_t* price) {
    fprintf(out, "%016" PRIx64, price->question);
    if (!price->feasible) {
        fprintf(out, " -\n");
        return;
    }
    fprintf(out, " %.17g %.17g %.17g", price->cost, price->time_s, price->impulse_Ns);
    for (int i = 0; i < 7; i++) fprintf(out, " %" PRId64, price->end[i]);
    fprintf(out, "\n");
}

/// In the order of their hashes, so that equal prices make equal files.
static bool write_prices(FILE* out, const cache_t* cache) {
    cache_price_t* const sorted = calloc((size_t)cache->count + 1, sizeof *sorted);
    int count = 0;
    if (sorted == NULL) return false;
    for (size_t i = 0; i < cache->room; i++) {
        if (cache->prices[i].question != 0) sorted[count++] = cache->prices[i];
    }
    qsort(sorted, (size_t)count, sizeof *sorted, by_question);
    for (int i = 0; i < count; i++) write_price(out, &sorted[i]);
    free(sorted);
    return true;
}

bool cache_write(FILE* out, const void* content) {
    const cache_t* const cache = content;
    char* text = NULL;
    size_t size = 0;
    FILE* const memory = open_memstream(&text, &size);
    bool sound = memory != NULL && fprintf(memory, "%s%s\n", FIRST_WORDS, cache->head) > 0;
    sound = sound && write_prices(memory, cache);
    sound = memory != NULL && fclose(memory) == 0 && sound;
    sound = sound && fwrite(text, 1, size, out) == size;
    sound = sound && fprintf(out, "%s%d %016" PRIx64 "\n", LAST_WORD, cache->count, sum_of(text, size)) > 0;
    free(text);
    return sound;
}

/// Reads one line, of which the sum has been right.
static bool read_price(const char* line, cache_price_t* price) {
    char* rest = NULL;
    *price = (cache_price_t){.question = strtoull(line, &rest, 16)};
    price->feasible = strncmp(rest, " -\n", 3) != 0;
    if (price->question == 0 || !price->feasible) return price->question != 0;
    double* const numbers[] = {&price->cost, &price->time_s, &price->impulse_Ns};
    bool sound = true;
    for (int i = 0; i < 3; i++) {
        *numbers[i] = strtod(rest, &rest);
        sound = sound && isfinite(*numbers[i]);
    }
    errno = 0;
    for (int i = 0; i < 7; i++) price->end[i] = strtoll(rest, &rest, 10);
    return sound && *rest == '\n' && errno == 0;
}

/// Where the last line begins; NULL if it is not what it should be.
static const char* last_line(const char* text, size_t size, int* count) {
    const char* const before = size < 2 || text[size - 1] != '\n' ? NULL : memrchr(text, '\n', size - 1);
    uint64_t sum = 0;
    int length = 0;
    if (before == NULL) return NULL;
    const bool sound = sscanf(before + 1, LAST_WORD "%d %16" SCNx64 "%n", count, &sum, &length) == 2;
    const size_t size_before = (size_t)(before + 1 - text);
    return sound && size_before + (size_t)length + 1 == size && sum == sum_of(text, size_before) ? before + 1 : NULL;
}

cache_status_t cache_read(cache_t* cache, const char* text, size_t size) {
    const size_t first = strlen(FIRST_WORDS), head = strlen(cache->head);
    int count = 0;
    if (size < first || memcmp(text, FIRST_WORDS, first) != 0) return CACHE_FOREIGN;
    const char* const end = last_line(text, size, &count);
    if (end == NULL) return CACHE_BROKEN;
    if (size < first + head + 1 || memcmp(&text[first], cache->head, head) != 0 || text[first + head] != '\n') {
        return CACHE_STALE;
    }
    cache_t* const whole = cache_open(cache->head);
    cache_status_t status = whole == NULL ? CACHE_NO_MEMORY : CACHE_READ;
    for (const char* line = &text[first + head + 1]; status == CACHE_READ && line < end;) {
        cache_price_t price;
        if (!read_price(line, &price))
            status = CACHE_BROKEN;
        else if (!cache_add(whole, &price))
            status = CACHE_NO_MEMORY;
        line = (const char*)memchr(line, '\n', (size_t)(end - line)) + 1;
    }
    if (status == CACHE_READ && whole->count != count) status = CACHE_BROKEN;
    for (size_t i = 0; status == CACHE_READ && i < whole->room; i++) {
        if (whole->prices[i].question != 0 && !cache_add(cache, &whole->prices[i])) status = CACHE_NO_MEMORY;
    }
    cache_close(whole);
    return status;
}
