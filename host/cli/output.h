/// Puts a finished text where the user wants it: whole or not at all.
#ifndef SSV_OUTPUT_H
#define SSV_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/// Writes the text to the file `path`, or to standard output if path is NULL or "-". A regular file is replaced in one
/// step: until then, and on failure or a signal, the old one stays as it was. A link to a file stays a link. Who may
/// read and write the file stays, set-uid bits do not. What is not a regular file (a pipe, a device) is written to in
/// place.
/// @return true; or false with the reason on standard error.
bool output_write(const char* path, const char* text, size_t size);

/// Writes what `report` writes of `content`, likewise; nothing where that is nothing.
/// @param report  @return false if it cannot, because of a number that is not finite or out of memory.
bool output_report(const char* path, bool (*report)(FILE* out, const void* content), const void* content);

#endif
