/// A page and what happens to it, for browsers on this machine: HTTP on loopback, events as they come (Server-Sent
/// Events). Whoever joins gets a snapshot first; whoever cannot keep up gets another one instead of what he missed.
/// Nothing that a browser sends is heard, and a page of another origin, or one that came under another host's name,
/// gets nothing.
#ifndef SSV_SERVE_H
#define SSV_SERVE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct serve serve_t;

/// What is served.
typedef struct {
    const char* page; ///< the HTML, which stays the caller's
    size_t page_size;
    char* (*snapshot)(void* context); ///< a JSON text without line ends, which is freed; NULL if out of memory
    void* context;
} serve_content_t;

/// @param port  0 for any that is free. @return NULL with a sentence in `error`.
serve_t* serve_open(int port, const serve_content_t* content, char* error, size_t error_size);

int serve_port(const serve_t* serve);

/// Can be read when there is something to do.
int serve_fd(const serve_t* serve);

/// Does some of what there is to do; wants to be called twice a second anyway. @return whether there is more.
bool serve_turn(serve_t* serve);

/// Tells all viewers: a JSON text without line ends.
void serve_tell(serve_t* serve, const char* json);

int serve_viewers(const serve_t* serve);

void serve_close(serve_t* serve);

#endif
