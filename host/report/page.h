/// The page: one file that shows what picture.h makes of a record, and needs nothing else.
#ifndef SSV_PAGE_H
#define SSV_PAGE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/// The page as it is installed, in two parts: its data stands between them.
typedef struct {
    char* text;
    size_t before, behind; ///< bytes before the data's place, and where the rest begins
} page_t;

/// Reads it from the folder that it is installed in. @return false with a sentence in `error`.
bool page_read(const char* folder, page_t* page, char* error, size_t error_size);

/// Writes the page with this data in it. @return false if it cannot.
bool page_write(FILE* out, const page_t* page, const json_t* data);

void page_free(page_t* page);

#endif
