/// A recorded log as tables: one CSV file for each kind of message and for each kind of list in one, with a row for
/// each of them and a column for each number. Every message is accounted for in messages.csv, also what is none of
/// ours.
#ifndef SSV_TABLES_H
#define SSV_TABLES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// A message as it was recorded.
typedef struct {
    int64_t number;      ///< in the log
    int64_t received_us; ///< since 1970
    const char* channel;
    const void* data;
    size_t size;
} tables_message_t;

typedef struct tables tables_t;

/// Begins all tables in a folder, which is made if there is none; tables of an earlier log there are replaced.
/// @return NULL with a sentence in `error`.
tables_t* tables_open(const char* folder, char* error, size_t error_size);

/// Adds a message. @return its type; NULL if it is none of ours, which messages.csv says, too.
const char* tables_add(tables_t* tables, const tables_message_t* message);

/// A table's name and how many rows it has by now; NULL behind the last one.
const char* tables_name(const tables_t* tables, int table, long* rows);

/// @return false with a sentence in `error` if something could not be written.
bool tables_close(tables_t* tables, char* error, size_t error_size);

#endif
