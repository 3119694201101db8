#define _POSIX_C_SOURCE 200809L
#include "page.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

/// What stands for the data in the page.
#define PLACE "@data@"
/// Digits of its numbers: 0.1 mm at 100 m, and less than a pixel anywhere.
#define DIGITS 7

bool page_read(const char* folder, page_t* page, char* error, size_t error_size) {
    char path[PATH_MAX];
    size_t size = 0;
    *page = (page_t){NULL, 0, 0};
    snprintf(path, sizeof path, "%s/report.html", folder);
    FILE* const file = fopen(path, "rb");
    FILE* const memory = open_memstream(&page->text, &size);
    char block[65536];
    bool sound = file != NULL && memory != NULL;
    for (size_t got = 1; sound && got > 0;) {
        got = fread(block, 1, sizeof block, file);
        sound = fwrite(block, 1, got, memory) == got && ferror(file) == 0;
    }
    const int why = errno;
    if (file != NULL) fclose(file);
    sound = memory != NULL && fclose(memory) == 0 && sound;
    const char* const place = sound ? strstr(page->text, PLACE) : NULL;
    if (place == NULL) {
        snprintf(error, error_size, "cannot read the page %s: %s", path,
                 sound ? "it has no place for data" : strerror(why));
        page_free(page);
        return false;
    }
    page->before = (size_t)(place - page->text);
    page->behind = page->before + strlen(PLACE);
    return true;
}

/// Called by jansson for each piece of the text. A "<" can stand in strings alone, where it would end the script.
static int write_harmless(const char* text, size_t size, void* context) {
    FILE* const out = context;
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '<' ? fputs("\\u003c", out) < 0 : fputc(text[i], out) == EOF) return -1;
    }
    return 0;
}

bool page_write(FILE* out, const page_t* page, const json_t* data) {
    return fwrite(page->text, 1, page->before, out) == page->before &&
           json_dump_callback(data, write_harmless, out, JSON_COMPACT | JSON_REAL_PRECISION(DIGITS)) == 0 &&
           fputs(page->text + page->behind, out) >= 0;
}

void page_free(page_t* page) {
    free(page->text);
    page->text = NULL;
}
