// Trees of values with their places, their faults in words, and the files that they are read from.
#define _POSIX_C_SOURCE 200809L
#include "tree.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/// No file of ours holds more, and no walk over one may go deeper.
#define ENTRIES_MAX 4096
#define KEYS_MAX 64
#define DEPTH_MAX 24
/// What a file is given at first, and twice as much whenever that is full [bytes].
#define FIRST_ROOM (1 << 16)

void* tree_memory_take(tree_memory_t* memory, size_t size) {
    void** const block = calloc(1, sizeof(max_align_t) + size);
    if (block == NULL) {
        return NULL;
    }
    *block = memory->newest;
    memory->newest = block;
    return (char*)block + sizeof(max_align_t);
}

void tree_memory_free(tree_memory_t* memory) {
    while (memory->newest != NULL) {
        void** const block = memory->newest;
        memory->newest = *block;
        free(block);
    }
}

/// Room for one more entry; it grows in powers of two, and what is outgrown is freed with the rest.
static tree_entry_t* new_entry(tree_memory_t* memory, tree_t* within) {
    if ((within->count & (within->count - 1)) == 0) {
        const size_t room = within->count == 0 ? 1 : 2 * (size_t)within->count;
        tree_entry_t* const larger = tree_memory_take(memory, room * sizeof *larger);
        if (larger == NULL) {
            return NULL;
        }
        if (within->count > 0) {
            memcpy(larger, within->entries, (size_t)within->count * sizeof *larger);
        }
        within->entries = larger;
    }
    return &within->entries[within->count++];
}

static int depth_of(const tree_t* tree) {
    int depth = 0;
    for (; tree != NULL; tree = tree->parent) {
        depth++;
    }
    return depth;
}

tree_t* tree_add(tree_memory_t* memory, tree_error_t* error, tree_t* within, const char* key, int line, int column) {
    tree_t* const value = tree_memory_take(memory, sizeof *value);
    if (value != NULL && within != NULL) {
        if (within->count >= (key == NULL ? ENTRIES_MAX : KEYS_MAX) || depth_of(within) >= DEPTH_MAX) {
            tree_fail(error, within, "more than any file of ours holds");
            return NULL;
        }
        value->file = within->file;
        value->parent = within;
        value->key = key;
        value->index = within->count;
        tree_entry_t* const entry = new_entry(memory, within);
        if (entry != NULL) {
            *entry = (tree_entry_t){key, line, column, value};
            return value;
        }
    }
    if (value == NULL || within != NULL) {
        snprintf(error->text, error->size, "out of memory");
        return NULL;
    }
    return value;
}

bool tree_graft(tree_memory_t* memory, tree_t* map, const char* key, const tree_t* value) {
    tree_entry_t* const entry = new_entry(memory, map);
    if (entry != NULL) {
        *entry = (tree_entry_t){key, value->line, value->column, value};
    }
    return entry != NULL;
}

const tree_t* tree_get(const tree_t* map, const char* key) {
    for (int i = 0; map != NULL && map->kind == TREE_MAP && i < map->count; i++) {
        if (strcmp(map->entries[i].key, key) == 0) {
            return map->entries[i].value;
        }
    }
    return NULL;
}

/// Appends the path from the root to a value.
static void add_path(const tree_t* at, char* text, size_t size) {
    const tree_t* chain[DEPTH_MAX + 2];
    int depth = 0;
    for (; at != NULL && at->parent != NULL && depth < DEPTH_MAX + 2; at = at->parent) {
        chain[depth++] = at;
    }
    while (depth-- > 0) {
        const size_t used = strlen(text);
        if (chain[depth]->key == NULL) {
            snprintf(text + used, size - used, "[%d]", chain[depth]->index);
        } else {
            snprintf(text + used, size - used, "%s%.64s", used == 0 ? "" : ".", chain[depth]->key);
        }
    }
}

static void add_place(const char* file, int line, int column, char* text, size_t size) {
    if (file == NULL) {
        text[0] = '\0';
    } else if (line > 0) {
        snprintf(text, size, "%s:%d:%d: ", file, line, column);
    } else {
        snprintf(text, size, "%s: ", file);
    }
}

static void fail_at(tree_error_t* error, const char* place, const char* path, const char* format, va_list args) {
    if (error->text[0] != '\0') {
        return;
    }
    char sentence[768];
    vsnprintf(sentence, sizeof sentence, format, args);
    snprintf(error->text, error->size, "%s%s%s%s", place, path, path[0] == '\0' ? "" : ": ", sentence);
    tree_make_harmless(error->text);
}

bool tree_fail(tree_error_t* error, const tree_t* at, const char* format, ...) {
    char place[512], path[256] = "";
    va_list args;
    add_place(at->file, at->line, at->column, place, sizeof place);
    add_path(at, path, sizeof path);
    va_start(args, format);
    fail_at(error, place, path, format, args);
    va_end(args);
    return false;
}

bool tree_fail_key(tree_error_t* error, const tree_t* map, const tree_entry_t* entry, const char* key,
                   const char* format, ...) {
    char place[512], path[320] = "";
    const tree_t* const near = entry == NULL ? map : NULL;
    va_list args;
    add_place(map->file, near != NULL ? near->line : entry->line, near != NULL ? near->column : entry->column, place,
              sizeof place);
    add_path(map, path, sizeof path - 70);
    const size_t used = strlen(path);
    snprintf(path + used, sizeof path - used, "%s%.64s", used == 0 ? "" : ".", key);
    va_start(args, format);
    fail_at(error, place, path, format, args);
    va_end(args);
    return false;
}

void tree_place(const tree_t* at, char* place, size_t size) {
    char path[256] = "";
    add_place(at->file, at->line, at->column, place, size);
    add_path(at, path, sizeof path);
    const size_t used = strlen(place);
    snprintf(place + used, size - used, "%s", path);
    tree_make_harmless(place);
}

/// How many bytes of UTF-8 stand there as one character that does not steer; 0 if they are none.
static size_t character(const char* text, size_t size) {
    const unsigned char first = (unsigned char)text[0];
    if (first < 0x80) {
        return first >= ' ' && first != 0x7f;
    }
    const size_t length = first >= 0xc2 && first < 0xe0   ? 2
                          : first >= 0xe0 && first < 0xf0 ? 3
                          : first >= 0xf0 && first < 0xf5 ? 4
                                                          : 0;
    for (size_t i = 1; i < length; i++) {
        if (i >= size || ((unsigned char)text[i] & 0xc0) != 0x80) {
            return 0;
        }
    }
    return first == 0xc2 && (unsigned char)text[1] < 0xa0 ? 0 : length;
}

void tree_make_harmless(char* text) {
    size_t size = strlen(text);
    while (size > 0) {
        const size_t length = character(text, size);
        if (length == 0) {
            *text = '?';
        }
        text += length == 0 ? 1 : length;
        size -= length == 0 ? 1 : length;
    }
}

int tree_find_no_text(const char* text, size_t size) {
    int line = 1;
    while (size > 0) {
        const size_t length = strchr("\t\r\n", *text) != NULL && *text != '\0' ? 1 : character(text, size);
        if (length == 0) {
            return line;
        }
        line += *text == '\n';
        text += length;
        size -= length;
    }
    return 0;
}

/// Smallest number of characters to change, drop or insert that makes one word of the other, up to the size of the row.
static int distance(const char* a, const char* b) {
    int row[65];
    const size_t length = strlen(b);
    if (length > 64) {
        return 64;
    }
    for (size_t j = 0; j <= length; j++) {
        row[j] = (int)j;
    }
    for (size_t i = 0; i < 64 && a[i] != '\0'; i++) {
        int diagonal = row[0];
        row[0] = (int)i + 1;
        for (size_t j = 0; j < length; j++) {
            const int above = row[j + 1], changed = diagonal + (a[i] != b[j]);
            const int least = above < row[j] ? above + 1 : row[j] + 1;
            row[j + 1] = changed < least ? changed : least;
            diagonal = above;
        }
    }
    return row[length];
}

const char* tree_nearest(const char* word, const char* const* known, int count) {
    const char* nearest = NULL;
    int least = 1 + (int)(strlen(word) / 3);
    for (int i = 0; i < count; i++) {
        const int steps = distance(word, known[i]);
        if (steps < least || (nearest == NULL && steps == least)) {
            least = steps;
            nearest = known[i];
        }
    }
    return nearest;
}

static char* refuse(tree_error_t* error, const char* path, const char* what) {
    const tree_t file = {.file = path};
    tree_fail(error, &file, "%s", what);
    return NULL;
}

static char* read_all(int file, const char* path, size_t* size, tree_error_t* error) {
    size_t room = FIRST_ROOM;
    char* text = malloc(room + 1);
    ssize_t got = text == NULL ? 0 : 1;
    *size = 0;
    while (got != 0 && *size <= TREE_TEXT_MAX) {
        if (*size == room) {
            room *= 2;
            char* const larger = realloc(text, room + 1);
            if (larger == NULL) free(text);
            text = larger;
            if (text == NULL) break;
        }
        got = read(file, text + *size, room - *size);
        if (got < 0 && errno != EINTR) {
            break;
        }
        *size += got > 0 ? (size_t)got : 0;
    }
    if (text != NULL && got >= 0 && *size <= TREE_TEXT_MAX) {
        text[*size] = '\0';
        return text;
    }
    refuse(error, path,
           text == NULL ? "out of memory"
           : got < 0    ? strerror(errno)
                        : "larger than 64 MiB, no file of ours is");
    free(text);
    return NULL;
}

char* tree_file_read(const char* path, size_t* size, tree_error_t* error) {
    if (strcmp(path, "-") == 0) {
        return read_all(STDIN_FILENO, "standard input", size, error);
    }
    struct stat status;
    char sentence[256];
    const int file = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (file < 0) {
        snprintf(sentence, sizeof sentence, "cannot open: %s", strerror(errno));
        return refuse(error, path, sentence);
    }
    char* text = NULL;
    if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
        refuse(error, path, "no regular file; give - to read standard input");
    } else {
        text = read_all(file, path, size, error);
    }
    close(file);
    return text;
}
