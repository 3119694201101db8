// A planner's end on UDP that has a simulator in lockstep fly the plan of a shipped scenario, open loop:
//   sim_pilot SCENARIO LINK_PORT LOCKSTEP_PORT [STOP_AFTER_S]
// uploads, commits, arms, starts and gives beats until the timeline is flown; with STOP_AFTER_S the beats stop then.
#define _DEFAULT_SOURCE
#include <arpa/inet.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shipped.h"
#include "ssv/link.h"

#define STEP_US 10000

static ssv_link_planner_t planner;
static ssv_timeline_t timeline;
static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
static int64_t now_us;
static int num_done;
static ssv_link_execution_t execution;

static int connect_to(const char* port) {
    const struct sockaddr_in peer = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(port)), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0 || connect(fd, (const struct sockaddr*)&peer, sizeof peer) != 0) {
        perror("socket");
        exit(3);
    }
    return fd;
}

static bool make_timeline(const char* name) {
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    ssv_fault_t fault;
    for (size_t i = 0; i < sizeof shipped / sizeof *shipped; i++) {
        if (strcmp(shipped[i].name, name) != 0) continue;
        if (ssv_problem_init(&problem, &shipped[i].scenario, &fault) != SSV_OK ||
            ssv_plan(&problem, &work, &plan) != SSV_OK)
            return false;
        ssv_timeline_of_plan(&plan, &timeline);
        return true;
    }
    return false;
}

static void take(const ssv_link_planner_event_t* event) {
    static const ssv_link_command_t next[] = {SSV_LINK_COMMIT, SSV_LINK_ARM, SSV_LINK_START};
    bool done = event->kind == SSV_LINK_PLANNER_UPLOADED;
    if (event->kind == SSV_LINK_PLANNER_EXECUTION) execution = event->of.execution;
    if (event->kind == SSV_LINK_PLANNER_ANSWERED) {
        done = event->of.answer.result == SSV_LINK_ACCEPTED;
        if (!done) {
            fprintf(stderr, "refused: %s\n", ssv_link_reason_str(event->of.answer.reason));
            exit(1);
        }
    }
    if (!done) return;
    if (num_done < 3) ssv_link_planner_command(&planner, now_us, next[num_done], 1, timeline.plan_hash);
    num_done++;
}

static void exchange(int link) {
    uint8_t bytes[2048];
    ssv_link_planner_event_t event;
    ssize_t got;
    size_t length;
    while ((got = recv(link, bytes, sizeof bytes, MSG_DONTWAIT)) > 0) {
        for (size_t at = 0; at < (size_t)got;) {
            at += ssv_link_planner_receive(&planner, now_us, bytes + at, (size_t)got - at, &event);
            take(&event);
        }
    }
    ssv_link_planner_receive(&planner, now_us, NULL, 0, &event);
    take(&event);
    while ((length = ssv_link_planner_poll(&planner, now_us, bytes)) > 0) send(link, bytes, length, 0);
}

// Lets the simulator run for a step. False when it is gone.
static bool step(int lockstep) {
    uint8_t bytes[8];
    struct pollfd wait = {.fd = lockstep, .events = POLLIN};
    now_us += STEP_US;
    for (int i = 0; i < 8; i++) bytes[i] = (uint8_t)((uint64_t)now_us >> 8 * i);
    return send(lockstep, bytes, sizeof bytes, 0) == sizeof bytes && poll(&wait, 1, 10000) == 1 &&
           recv(lockstep, bytes, sizeof bytes, 0) == sizeof bytes;
}

int main(int argc, char** argv) {
    if (argc < 4 || !make_timeline(argv[1])) return 2;
    const int link = connect_to(argv[2]), lockstep = connect_to(argv[3]);
    const double stop_s = argc > 4 ? atof(argv[4]) : 1e9;
    const ssv_timeline_stamp_t stamp = {INT64_C(1767225600000000), 600000};
    const ssv_link_planner_config_t config = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                              .compid = SSV_LINK_PLANNER_COMPID,
                                              .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                              .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                              .boot_id = 5};
    ssv_link_planner_init(&planner, &config);
    const size_t length = ssv_timeline_encode(&timeline, &stamp, file, sizeof file);
    if (!ssv_link_planner_upload(&planner, file, length)) return 2;
    for (uint32_t progress = 1;; progress++) {
        if (1e-6 * (double)now_us < stop_s) ssv_link_planner_beat(&planner, 1, progress);
        exchange(link);
        if (!step(lockstep) || execution.phase == SSV_LINK_DONE || execution.phase == SSV_LINK_STOPPED) break;
    }
    for (int i = 0; i < 200 && step(lockstep); i++) {}
    printf("%d %d\n", (int)execution.phase, (int)execution.reason);
    return 0;
}
