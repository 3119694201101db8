#define _DEFAULT_SOURCE
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "wire/tree.h"

static bool fail(const char* path) {
    char shown[PATH_MAX];
    const char* const why = strerror(errno);
    snprintf(shown, sizeof shown, "%s", path);
    tree_make_harmless(shown);
    fprintf(stderr, "ssv: cannot write %s: %s\n", shown, why);
    return false;
}

static bool write_whole(int file, const char* text, size_t size) {
    while (size > 0) {
        const ssize_t written = write(file, text, size);
        if (written < 0 && errno != EINTR) {
            return false;
        }
        text += written > 0 ? written : 0;
        size -= written > 0 ? (size_t)written : 0;
    }
    return true;
}

/// Writes beside the file and renames over it.
static bool replace(const char* path, mode_t mode, const char* text, size_t size) {
    char beside[PATH_MAX];
    const int length = snprintf(beside, sizeof beside, "%s.XXXXXX", path);
    if (length < 0 || (size_t)length >= sizeof beside) {
        errno = ENAMETOOLONG;
        return false;
    }
    const int file = mkstemp(beside);
    if (file < 0) {
        return false;
    }
    bool done = write_whole(file, text, size) && fchmod(file, mode) == 0;
    done = close(file) == 0 && done;
    done = done && rename(beside, path) == 0;
    if (!done) {
        const int why = errno;
        unlink(beside);
        errno = why;
    }
    return done;
}

/// The permissions of a new file.
static mode_t new_file_mode(void) {
    const mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

/// The file that a path means, at the end of its links, even where there is none yet. @return false with errno set.
static bool follow_links(const char* path, char* target, size_t size) {
    int length = snprintf(target, size, "%s", path);
    for (int links = 0; length >= 0 && (size_t)length < size; links++) {
        char link[PATH_MAX];
        const ssize_t link_length = readlink(target, link, sizeof link - 1);
        if (link_length < 0) {
            return errno == EINVAL || errno == ENOENT; // no link, or nothing yet
        }
        if (links == 40) {
            errno = ELOOP;
            return false;
        }
        link[link_length] = '\0';
        const char* const slash = strrchr(target, '/');
        const int folder_length = link[0] == '/' || slash == NULL ? 0 : (int)(slash + 1 - target);
        char next[PATH_MAX];
        length = snprintf(next, sizeof next, "%.*s%s", folder_length, target, link);
        if (length >= 0 && (size_t)length < sizeof next) {
            snprintf(target, size, "%s", next);
        }
    }
    errno = ENAMETOOLONG;
    return false;
}

bool output_write(const char* path, const char* text, size_t size) {
    if (path == NULL || strcmp(path, "-") == 0) {
        return write_whole(STDOUT_FILENO, text, size) || fail("standard output");
    }
    struct stat old;
    const bool exists = stat(path, &old) == 0;
    if (exists && !S_ISREG(old.st_mode)) {
        const int file = open(path, O_WRONLY);
        if (file < 0) {
            return fail(path);
        }
        const bool written = write_whole(file, text, size);
        return (close(file) == 0 && written) || fail(path);
    }

    // A link stays a link: the file that it leads to is the one replaced.
    char target[PATH_MAX];
    if (!follow_links(path, target, sizeof target)) {
        return fail(path);
    }
    sigset_t all, before;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, &before); // a Ctrl-C waits for these few milliseconds
    const bool done = replace(target, exists ? old.st_mode & 0777 : new_file_mode(), text, size) || fail(path);
    sigprocmask(SIG_SETMASK, &before, NULL);
    return done;
}

bool output_report(const char* path, bool (*report)(FILE* out, const void* content), const void* content) {
    char* text = NULL;
    size_t size = 0;
    FILE* memory = open_memstream(&text, &size);
    bool complete = memory != NULL && report(memory, content);
    complete = memory != NULL && fclose(memory) == 0 && complete;
    if (!complete) {
        fprintf(stderr, "ssv: the answer holds a number that is not finite, or memory ran out\n");
    }
    const bool written = complete && (size == 0 || output_write(path, text, size));
    free(text);
    return written;
}
