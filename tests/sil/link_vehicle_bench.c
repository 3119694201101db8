// The vehicle's end of the link on a UDP socket, for tools of others: it accepts what it is told and flies nothing.
//   link_vehicle_bench PORT [PEER_PORT]
// listens on 127.0.0.1:PORT (0: any) and prints the port; answers whoever spoke last, or before that PEER_PORT. With
// SSV_LINK_KEY set, a letter, it signs and asks for signatures; the key is 32 times that letter.
#define _DEFAULT_SOURCE
#include <arpa/inet.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "ssv/link.h"
#include "two_ends.h"

static ssv_link_vehicle_t vehicle;
static ssv_link_vehicle_state_t state;
static int64_t start_us;

static int64_t clock_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

static ssv_link_result_t obey(const ssv_link_vehicle_event_t* event, ssv_link_reason_t* reason) {
    const bool is_armed = state.phase != SSV_LINK_DISARMED;
    *reason = SSV_LINK_NO_REASON;
    switch (event->of.command.command) {
        case SSV_LINK_ARM:
            state.phase = event->of.command.value == 1 ? SSV_LINK_READY : SSV_LINK_DISARMED;
            return SSV_LINK_ACCEPTED;
        case SSV_LINK_START:
            if (!is_armed) {
                *reason = SSV_LINK_NOT_ARMED;
                return SSV_LINK_DENIED;
            }
            state.phase = SSV_LINK_EXECUTING;
            return SSV_LINK_ACCEPTED;
        case SSV_LINK_TERMINATE:
            state.phase = SSV_LINK_STOPPED;
            state.reason = SSV_LINK_COMMANDED;
            return SSV_LINK_ACCEPTED;
        default: return SSV_LINK_ACCEPTED;
    }
}

static void take(int64_t now_us, const uint8_t* bytes, size_t length) {
    ssv_link_vehicle_event_t event;
    for (size_t at = 0; at < length;) {
        at += ssv_link_vehicle_receive(&vehicle, now_us, &state, bytes + at, length - at, &event);
        if (event.kind == SSV_LINK_VEHICLE_BEAT) state.beat = event.of.beat.progress;
        if (event.kind == SSV_LINK_VEHICLE_COMMANDED) {
            ssv_link_reason_t reason;
            const ssv_link_result_t result = obey(&event, &reason);
            ssv_link_vehicle_answer(&vehicle, &event, result, reason);
        }
    }
}

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    struct sockaddr_in own = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(argv[1])), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct sockaddr_in peer = own;
    socklen_t size = sizeof own;
    bool has_peer = argc > 2;
    if (fd < 0 || bind(fd, (struct sockaddr*)&own, size) != 0 || getsockname(fd, (struct sockaddr*)&own, &size) != 0) {
        perror("socket");
        return 1;
    }
    if (has_peer) peer.sin_port = htons((uint16_t)atoi(argv[2]));
    printf("%d\n", ntohs(own.sin_port));
    fflush(stdout);
    ssv_link_vehicle_config_t config = default_vehicle();
    const char* key = getenv("SSV_LINK_KEY");
    if (key != NULL) {
        config.sign = true;
        memset(config.signing.key, key[0], sizeof config.signing.key);
        config.signing.unix_zero_us = (int64_t)time(NULL) * 1000000;
    }
    ssv_link_vehicle_init(&vehicle, &config);
    state.may_swap = true;
    state.pose.known = true;
    state.pose.q_IS[0] = 1;
    start_us = clock_us();
    ssv_link_vehicle_say(&vehicle, 0, SSV_LINK_INFO, "bench ready");
    for (;;) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};
        uint8_t bytes[2048], frame[SSV_LINK_FRAME_BYTES_MAX];
        size_t length;
        if (poll(&wait, 1, 5) > 0) {
            size = sizeof peer;
            const ssize_t got = recvfrom(fd, bytes, sizeof bytes, 0, (struct sockaddr*)&peer, &size);
            if (got > 0) {
                has_peer = true;
                take(clock_us() - start_us, bytes, (size_t)got);
            }
        }
        while (has_peer && (length = ssv_link_vehicle_poll(&vehicle, clock_us() - start_us, &state, frame)) > 0)
            sendto(fd, frame, length, 0, (struct sockaddr*)&peer, sizeof peer);
    }
}
