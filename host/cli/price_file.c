#define _POSIX_C_SOURCE 200809L
#include "price_file.h"

#include <errno.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "output.h"
#include "wire/tree.h"

/// The whole file and a zero behind it. @return NULL with errno set; EINVAL if it is no regular file.
static char* read_whole(const char* path, size_t* size) {
    struct stat status;
    FILE* const file = fopen(path, "re");
    if (file == NULL) return NULL;
    errno = EINVAL;
    const bool is_regular = fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size < INT_MAX;
    char* const text = is_regular ? malloc((size_t)status.st_size + 1) : NULL;
    if (text != NULL) {
        *size = fread(text, 1, (size_t)status.st_size, file);
        text[*size] = '\0';
    }
    const int why = errno;
    fclose(file);
    errno = why;
    return text;
}

/// @param tells  whether to say what is not used.
static bool take(cache_t* cache, const char* path, bool tells, char* error, size_t error_size) {
    char shown[256];
    size_t size = 0;
    snprintf(shown, sizeof shown, "%s", path);
    tree_make_harmless(shown);
    char* const text = read_whole(path, &size);
    if (text == NULL) {
        if (errno == ENOENT) return true;
        snprintf(error, error_size, "cannot read prices from %s: %s", shown,
                 errno == EINVAL ? "no regular file" : strerror(errno));
        return false;
    }
    const cache_status_t status = size == 0 ? CACHE_READ : cache_read(cache, text, size);
    free(text);
    const char* const why = status == CACHE_STALE    ? "holds prices of another planner, arithmetic or effort"
                            : status == CACHE_BROKEN ? "is not whole"
                                                     : NULL;
    if (status == CACHE_FOREIGN) {
        snprintf(error, error_size, "%s is no file of prices, and would be overwritten; give --cache another name",
                 shown);
    } else if (status == CACHE_NO_MEMORY) {
        snprintf(error, error_size, "out of memory");
    } else if (why != NULL && tells) {
        fprintf(stderr, "ssv: %s %s; it is not used, and written anew\n", shown, why);
    }
    return status != CACHE_FOREIGN && status != CACHE_NO_MEMORY;
}

bool price_file_read(cache_t* cache, const char* path, char* error, size_t error_size) {
    return take(cache, path, true, error, error_size);
}

bool price_file_write(cache_t* cache, const char* path) {
    char error[512];
    if (!take(cache, path, false, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return false;
    }
    return output_report(path, cache_write, cache);
}
