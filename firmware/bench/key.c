#define _DEFAULT_SOURCE
#include "bench/key.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

static bool fail(char* error, size_t error_size, const char* path, const char* why) {
    (void)snprintf(error, error_size, "%s: %s", path, why);
    return false;
}

static int digit(char letter) {
    return isdigit((unsigned char)letter)   ? letter - '0'
           : letter >= 'a' && letter <= 'f' ? letter - 'a' + 10
           : letter >= 'A' && letter <= 'F' ? letter - 'A' + 10
                                            : -1;
}

// All of the text is the key, but for white space behind it.
static bool parse(const char* text, size_t length, uint8_t key[32]) {
    while (length > 0 && isspace((unsigned char)text[length - 1])) length--;
    if (length != 64) return false;
    for (int i = 0; i < 32; i++) {
        const int high = digit(text[2 * i]), low = digit(text[2 * i + 1]);
        if (high < 0 || low < 0) return false;
        key[i] = (uint8_t)(16 * high + low);
    }
    return true;
}

bool key_read(const char* path, int64_t now_us, ssv_link_signing_t* signing, char* error, size_t error_size) {
    char text[100];
    struct stat state;
    struct timespec wall;
    FILE* file = fopen(path, "r");
    if (file == NULL) return fail(error, error_size, path, strerror(errno));
    const bool is_secret = fstat(fileno(file), &state) == 0 && (state.st_mode & (S_IRWXG | S_IRWXO)) == 0;
    const size_t length = fread(text, 1, sizeof text, file);
    fclose(file);
    memset(signing, 0, sizeof *signing);
    if (!is_secret) return fail(error, error_size, path, "others may read this key; chmod 600 it");
    if (!parse(text, length, signing->key))
        return fail(error, error_size, path, "is no key: 64 hexadecimal digits, as `openssl rand -hex 32` makes them");
    clock_gettime(CLOCK_REALTIME, &wall);
    signing->unix_zero_us = (int64_t)wall.tv_sec * 1000000 + wall.tv_nsec / 1000 - now_us;
    return true;
}
