#define _GNU_SOURCE
#include "serve.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/// Events that are kept for viewers that are a little behind, and how much memory they may take.
#define EVENTS 8192
#define EVENTS_BYTES_MAX (16 << 20)
#define VIEWERS_MAX 64
/// [s] Of silence, after which a viewer is told that there is nothing to tell; of none taken, after which he is gone.
#define HEARTBEAT_S 10
#define STALLED_S 30
#define BLOCK_SIZE 65536

typedef struct viewer viewer_t;

struct viewer {
    serve_t* serve;
    struct MHD_Connection* connection;
    viewer_t *before, *behind;
    long long next; ///< number of the entry that is his next
    char* frame;    ///< under way to him; NULL if none is
    const char* at; ///< what is left of it
    bool is_asleep;
};

struct serve {
    struct MHD_Daemon* daemon;
    serve_content_t content;
    int port, epoll_fd, num_viewers;
    viewer_t* viewers;
    char* entry[EVENTS];         ///< frames as they are sent
    long long oldest, end, told; ///< entries [oldest, end) are kept; events told so far
    size_t bytes;
    time_t spoke_s;
};

// ---- Entries --------------------------------------------------------------------------------------------------------

static void drop_oldest(serve_t* serve) {
    char** const entry = &serve->entry[serve->oldest++ % EVENTS];
    serve->bytes -= strlen(*entry) + 1;
    free(*entry);
    *entry = NULL;
}

static void wake_all(serve_t* serve) {
    for (viewer_t* viewer = serve->viewers; viewer != NULL; viewer = viewer->behind) {
        if (!viewer->is_asleep) continue;
        viewer->is_asleep = false;
        MHD_resume_connection(viewer->connection);
    }
}

/// Takes over a frame.
static void add_entry(serve_t* serve, char* frame) {
    if (frame == NULL) return;
    serve->bytes += strlen(frame) + 1;
    while (serve->end - serve->oldest == EVENTS || (serve->bytes > EVENTS_BYTES_MAX && serve->oldest < serve->end))
        drop_oldest(serve);
    serve->entry[serve->end++ % EVENTS] = frame;
    serve->spoke_s = time(NULL);
    wake_all(serve);
}

static char* frame_of(long long number, const char* json) {
    char* frame = NULL;
    return json != NULL && asprintf(&frame, "id: %lld\ndata: %s\n\n", number, json) >= 0 ? frame : NULL;
}

void serve_tell(serve_t* serve, const char* json) { add_entry(serve, frame_of(++serve->told, json)); }

// ---- Viewers --------------------------------------------------------------------------------------------------------

/// From here on a viewer gets what comes after a snapshot of now.
static void begin_anew(viewer_t* viewer) {
    serve_t* const serve = viewer->serve;
    char* const json = serve->content.snapshot(serve->content.context);
    free(viewer->frame);
    viewer->at = viewer->frame = frame_of(serve->told, json);
    viewer->next = serve->end;
    free(json);
}

/// The frame that a viewer gets next, if there is one. It is a copy, since the entry may be dropped while he gets it.
static void take_next(viewer_t* viewer) {
    const serve_t* const serve = viewer->serve;
    free(viewer->frame);
    viewer->at = viewer->frame = NULL;
    if (viewer->next < serve->oldest) {
        begin_anew(viewer);
    } else if (viewer->next < serve->end) {
        viewer->at = viewer->frame = strdup(serve->entry[viewer->next++ % EVENTS]);
    }
}

/// Copies frames into a block, whole or in the parts that fit.
static size_t fill(viewer_t* viewer, char* block, size_t size) {
    size_t filled = 0;
    while (filled < size) {
        if (viewer->at == NULL || *viewer->at == '\0') {
            take_next(viewer);
            if (viewer->at == NULL) break;
        }
        const size_t left = strlen(viewer->at), sent = left < size - filled ? left : size - filled;
        memcpy(block + filled, viewer->at, sent);
        viewer->at += sent;
        filled += sent;
    }
    return filled;
}

/// What microhttpd calls for more of an answer that never ends.
static ssize_t more(void* context, uint64_t position, char* block, size_t size) {
    viewer_t* const viewer = context;
    (void)position;
    const size_t filled = fill(viewer, block, size);
    if (filled > 0) return (ssize_t)filled;
    viewer->is_asleep = true;
    MHD_suspend_connection(viewer->connection);
    return 0;
}

static void forget(void* context) {
    viewer_t* const viewer = context;
    if (viewer->before != NULL)
        viewer->before->behind = viewer->behind;
    else
        viewer->serve->viewers = viewer->behind;
    if (viewer->behind != NULL) viewer->behind->before = viewer->before;
    viewer->serve->num_viewers--;
    free(viewer->frame);
    free(viewer);
}

// ---- Questions of browsers ------------------------------------------------------------------------------------------

static const char* header(struct MHD_Connection* connection, const char* name) {
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

/// Whether a host is this machine by one of its own names: another one may have been made to mean it by whoever owns
/// that name, and his page must not read ours.
static bool is_ours(const serve_t* serve, const char* host) {
    static const char* const names[] = {"127.0.0.1", "localhost"};
    char ours[64];
    for (size_t i = 0; host != NULL && i < sizeof names / sizeof names[0]; i++) {
        snprintf(ours, sizeof ours, "%s:%d", names[i], serve->port);
        if (strcmp(host, ours) == 0) return true;
    }
    return false;
}

static bool may_read(const serve_t* serve, struct MHD_Connection* connection) {
    static const char scheme[] = "http://";
    const char *const origin = header(connection, "Origin"), *const site = header(connection, "Sec-Fetch-Site");
    const char* const mode = header(connection, "Sec-Fetch-Mode");
    if (!is_ours(serve, header(connection, "Host"))) return false;
    if (origin != NULL &&
        (strncmp(origin, scheme, sizeof scheme - 1) != 0 || !is_ours(serve, origin + sizeof scheme - 1))) {
        return false;
    }
    const bool is_elsewhere = site != NULL && strcmp(site, "same-origin") != 0 && strcmp(site, "none") != 0;
    return !is_elsewhere || (mode != NULL && strcmp(mode, "navigate") == 0); // a link from elsewhere may lead here
}

static enum MHD_Result answer(struct MHD_Connection* connection, unsigned status, struct MHD_Response* response,
                              const char* type) {
    static const char* const headers[][2] = {
        {"Cache-Control", "no-store"},
        {"X-Content-Type-Options", "nosniff"},
        {"Content-Security-Policy", "frame-ancestors 'none'"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Referrer-Policy", "no-referrer"},
    };
    if (response == NULL) return MHD_NO;
    for (size_t i = 0; i < sizeof headers / sizeof headers[0]; i++)
        (void)MHD_add_response_header(response, headers[i][0], headers[i][1]);
    (void)MHD_add_response_header(response, "Content-Type", type);
    const enum MHD_Result queued = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return queued;
}

static enum MHD_Result answer_nothing(struct MHD_Connection* connection, unsigned status) {
    return answer(connection, status, MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT), "text/plain");
}

static enum MHD_Result answer_events(serve_t* serve, struct MHD_Connection* connection) {
    viewer_t* const viewer = calloc(1, sizeof *viewer);
    if (viewer == NULL) return MHD_NO;
    *viewer = (viewer_t){.serve = serve, .connection = connection, .behind = serve->viewers};
    if (serve->viewers != NULL) serve->viewers->before = viewer;
    serve->viewers = viewer;
    serve->num_viewers++;
    begin_anew(viewer);
    struct MHD_Response* const response =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK_SIZE, more, viewer, forget);
    if (response == NULL) forget(viewer);
    return answer(connection, MHD_HTTP_OK, response, "text/event-stream");
}

static enum MHD_Result asked(void* context, struct MHD_Connection* connection, const char* url, const char* method,
                             const char* version, const char* upload, size_t* upload_size, void** state) {
    serve_t* const serve = context;
    (void)version;
    (void)upload;
    if (*state == NULL) { // the headers are there, and nothing else: answers come at the second call
        *state = serve;
        return MHD_YES;
    }
    if (*upload_size > 0) { // what is sent is not looked at
        *upload_size = 0;
        return MHD_YES;
    }
    if (!may_read(serve, connection)) return answer_nothing(connection, MHD_HTTP_FORBIDDEN);
    if (strcmp(method, MHD_HTTP_METHOD_GET) != 0) return answer_nothing(connection, MHD_HTTP_METHOD_NOT_ALLOWED);
    if (strcmp(url, "/events") == 0) return answer_events(serve, connection);
    if (strcmp(url, "/") != 0) return answer_nothing(connection, MHD_HTTP_NOT_FOUND);
    struct MHD_Response* const page = MHD_create_response_from_buffer(
        serve->content.page_size, (void*)(uintptr_t)serve->content.page, MHD_RESPMEM_PERSISTENT);
    return answer(connection, MHD_HTTP_OK, page, "text/html; charset=utf-8");
}

// ---- The server -----------------------------------------------------------------------------------------------------

serve_t* serve_open(int port, const serve_content_t* content, char* error, size_t error_size) {
    serve_t* const serve = calloc(1, sizeof *serve);
    const struct sockaddr_in loopback = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    if (serve == NULL) {
        snprintf(error, error_size, "out of memory");
        return NULL;
    }
    serve->content = *content;
    serve->spoke_s = time(NULL);
    serve->daemon =
        MHD_start_daemon(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME, 0, NULL, NULL, asked, serve, MHD_OPTION_SOCK_ADDR,
                         &loopback, MHD_OPTION_CONNECTION_LIMIT, (unsigned)VIEWERS_MAX, MHD_OPTION_CONNECTION_TIMEOUT,
                         (unsigned)STALLED_S, MHD_OPTION_END);
    const union MHD_DaemonInfo* const epoll =
        serve->daemon == NULL ? NULL : MHD_get_daemon_info(serve->daemon, MHD_DAEMON_INFO_EPOLL_FD);
    const union MHD_DaemonInfo* const bound =
        serve->daemon == NULL ? NULL : MHD_get_daemon_info(serve->daemon, MHD_DAEMON_INFO_BIND_PORT);
    if (epoll == NULL || bound == NULL) {
        snprintf(error, error_size, "cannot listen on 127.0.0.1:%d: %s; --port takes another one, 0 any that is free",
                 port, strerror(errno));
        serve_close(serve);
        return NULL;
    }
    serve->epoll_fd = epoll->epoll_fd;
    serve->port = bound->port;
    return serve;
}

int serve_port(const serve_t* serve) { return serve->port; }

int serve_fd(const serve_t* serve) { return serve->epoll_fd; }

int serve_viewers(const serve_t* serve) { return serve->num_viewers; }

bool serve_turn(serve_t* serve) {
    MHD_UNSIGNED_LONG_LONG wait_ms = 1;
    if (time(NULL) - serve->spoke_s >= HEARTBEAT_S) add_entry(serve, strdup(":\n\n"));
    (void)MHD_run(serve->daemon);
    return MHD_get_timeout(serve->daemon, &wait_ms) == MHD_YES && wait_ms == 0;
}

void serve_close(serve_t* serve) {
    wake_all(serve);
    if (serve->daemon != NULL) MHD_stop_daemon(serve->daemon);
    while (serve->oldest < serve->end) drop_oldest(serve);
    free(serve);
}
