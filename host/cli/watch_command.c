// `ssv watch`: what happens on the bus, as a page that moves while it happens.
#define _GNU_SOURCE
#include <argp.h>
#include <jansson.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "channels.h"
#include "commands.h"
#include "line.h"
#include "report/live.h"
#include "report/page.h"
#include "report/serve.h"
#include "task_options.h"
#include "wire/tree.h"

static const char doc[] =
    "Shows in a browser what happens on the bus while it happens: the newest plan, a flight beside its plan, an "
    "assembly that grows, and how planners and link do."
    "\vExamples:\n"
    "  ssv watch                                then open http://127.0.0.1:8667/\n"
    "  ssv fly task.yaml --sim --rate 20 --lcm  meanwhile, in another terminal\n"
    "  ssv watch --lcm 'udpm://239.255.76.67:7667?ttl=1'\n"
    "                                           listens to a vehicle's network\n"
    "\n"
    "It listens, and sends nothing to anybody. The page is for browsers on this machine: from another one, go through "
    "ssh -L 8667:127.0.0.1:8667. As many may watch as like to; who joins late sees all of the flight so far, if the "
    "watch was there when its plan was made. Ctrl-C ends it.\n"
    "\n"
    "Exit codes:\n"
    "   0  ended by Ctrl-C\n"
    "   4  LCM does not work here\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. the port is taken\n";

enum { KEY_LCM = 256, KEY_PORT, PORT = 8667 };
/// [s] How often the server wants a turn anyway.
#define TURN_S 0.5
/// Digits of numbers, as of the page's own.
#define DIGITS 7

static const struct argp_option options[] = {
    {"lcm", KEY_LCM, "URL", 0, "The bus (default: $LCM_DEFAULT_URL, else UDP multicast on this machine)", 0},
    {"port", KEY_PORT, "N", 0, "Where the page is, on 127.0.0.1 (default 8667); 0 for any that is free", 0},
    {0}};

typedef struct {
    const char* lcm_url;
    int port;
} arguments_t;

/// Begins with the line, as what receives messages must.
typedef struct {
    line_t line;
    live_t* live;
    serve_t* serve;
} watch_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* const arguments = state->input;
    double port = 0;
    switch (key) {
        case KEY_LCM: arguments->lcm_url = argument; return 0;
        case KEY_PORT:
            if (!tree_number(argument, &port) || !(port >= 0 && port <= 65535) || port != (int)port)
                argp_error(state, "--port %s: not a whole number in [0, 65535]", argument);
            arguments->port = (int)port;
            return 0;
        case ARGP_KEY_ARG: argp_error(state, "there are no arguments, but there is '%s'", argument); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static char* text_of(json_t* json) {
    char* const text = json == NULL ? NULL : json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(DIGITS));
    json_decref(json);
    return text;
}

static char* snapshot(void* context) { return text_of(live_snapshot(((const watch_t*)context)->live)); }

static void received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    const watch_t* const watch = context;
    if (datagram->data_size > LINE_DATAGRAM_MAX) return;
    char* const event = text_of(live_take(watch->live, channel, datagram->data, datagram->data_size, line_now_s()));
    if (event != NULL) serve_tell(watch->serve, event);
    free(event);
}

/// One descriptor for the server and for the signals that end it. @return -1 if the system gives none.
static int wake_fd(int server_fd, int* signal_fd) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGHUP);
    const int epoll = epoll_create1(EPOLL_CLOEXEC);
    *signal_fd = sigprocmask(SIG_BLOCK, &set, NULL) == 0 ? signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK) : -1;
    struct epoll_event server = {.events = EPOLLIN}, signal = {.events = EPOLLIN};
    if (epoll >= 0 && *signal_fd >= 0 && epoll_ctl(epoll, EPOLL_CTL_ADD, server_fd, &server) == 0 &&
        epoll_ctl(epoll, EPOLL_CTL_ADD, *signal_fd, &signal) == 0) {
        return epoll;
    }
    if (epoll >= 0) close(epoll);
    return -1;
}

/// Until a signal. @return the exit code.
static int watch_on(watch_t* watch) {
    struct signalfd_siginfo signal;
    char error[1024];
    int signal_fd = -1;
    const int wake = wake_fd(serve_fd(watch->serve), &signal_fd);
    if (wake < 0) {
        fprintf(stderr, "ssv: the system gives no files for a server\n");
        return EXIT_FAILED;
    }
    int code = EXIT_OK;
    bool has_more = false;
    while (read(signal_fd, &signal, sizeof signal) < 0) {
        if (!line_wait(&watch->line, line_now_s() + (has_more ? 0 : TURN_S), wake, error, sizeof error)) {
            fprintf(stderr, "ssv: %s\n", error);
            code = EXIT_NO_ANSWER;
            break;
        }
        has_more = serve_turn(watch->serve);
    }
    close(wake);
    close(signal_fd);
    return code;
}

static bool listen_on_bus(watch_t* watch, char* error, size_t error_size) {
    static const char* const more[] = {CHANNEL_SCENARIO, CHANNEL_EXECUTE, CHANNEL_EXECUTION,
                                       CHANNEL_STATE,    CHANNEL_TRUTH,   CHANNEL_STATUS};
    if (!line_open(&watch->line, received, watch, error, error_size)) return false;
    for (size_t i = 0; i < sizeof more / sizeof more[0]; i++) {
        if (line_hear(&watch->line, more[i], received, watch, error, error_size)) continue;
        line_close(&watch->line);
        return false;
    }
    return true;
}

/// @return the exit code.
static int serve_page(watch_t* watch, int port, const char* page, size_t size) {
    char error[1024];
    long taken = 0, refused = 0;
    const serve_content_t content = {page, size, snapshot, watch};
    watch->serve = serve_open(port, &content, error, sizeof error);
    if (watch->serve == NULL) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_FAILED;
    }
    int code = EXIT_NO_ANSWER;
    if (listen_on_bus(watch, error, sizeof error)) {
        fprintf(stderr, "ssv: http://127.0.0.1:%d/ shows what happens; Ctrl-C ends it\n", serve_port(watch->serve));
        code = watch_on(watch);
        live_counts(watch->live, &taken, &refused);
        fprintf(stderr, "ssv: heard %ld messages, %ld of them not what their channel is for\n", taken, refused);
        line_close(&watch->line);
    } else {
        fprintf(stderr, "ssv: %s\n", error);
    }
    serve_close(watch->serve);
    return code;
}

static bool write_live_page(FILE* out, const page_t* page) {
    json_t* const data = json_pack("{s:s,s:[],s:b}", "title", "ssv watch", "tasks", "live", 1);
    const bool written = page_write(out, page, data);
    json_decref(data);
    return written;
}

int watch_command(int argc, char** argv) {
    static const struct argp parser = {options, parse_option, NULL, doc, NULL, NULL, NULL};
    arguments_t arguments = {NULL, PORT};
    char name[] = "ssv watch", error[1024] = "out of memory";
    char* const command = argv[0];
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);
    argv[0] = command;

    char *text = NULL, *const folder = task_data_folder(SSV_REPORT_FROM_BIN);
    size_t size = 0;
    page_t page = {NULL, 0, 0};
    watch_t watch = {.line = {.url = arguments.lcm_url, .answer_channel = CHANNEL_PLAN}, .live = live_begin()};
    FILE* const memory = open_memstream(&text, &size);
    bool sound = folder != NULL && watch.live != NULL && memory != NULL &&
                 page_read(folder, &page, error, sizeof error) && write_live_page(memory, &page);
    sound = memory != NULL && fclose(memory) == 0 && sound;
    if (!sound) fprintf(stderr, "ssv: %s\n", error);
    const int code = sound ? serve_page(&watch, arguments.port, text, size) : EXIT_FAILED;
    if (watch.live != NULL) live_end(watch.live);
    page_free(&page);
    free(folder);
    free(text);
    return code;
}
