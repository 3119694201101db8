// What to do about an LCM address that could not be opened.
#define _POSIX_C_SOURCE 200809L
#include "ssv/address.h"

#include <arpa/inet.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXAMPLE "udpm://239.255.76.67:7667?ttl=0"

static bool is_provider(const char* url, const char* name) {
    const size_t length = strlen(name);
    return strncmp(url, name, length) == 0 && strncmp(url + length, "://", 3) == 0;
}

/// Of udpm://GROUP:PORT?OPTIONS, where each part may be left out.
static void advise_on_multicast(const char* target, char* advice) {
    char group[32], port[16] = "";
    const size_t group_size = strcspn(target, ":?"), port_at = group_size + (target[group_size] == ':');
    snprintf(group, sizeof group, "%.*s", (int)group_size, target);
    snprintf(port, sizeof port, "%.*s", (int)strcspn(target + port_at, "?"), target + port_at);
    struct in_addr address;
    const bool is_address = inet_pton(AF_INET, group, &address) == 1;
    if (group[0] != '\0' && (!is_address || ntohl(address.s_addr) >> 28 != 0xe)) {
        snprintf(advice, SSV_ADVICE_SIZE,
                 "'%s' is no multicast group, which is 224.0.0.0 to 239.255.255.255, as in " EXAMPLE, group);
    } else if (port[0] != '\0' &&
               (strspn(port, "0123456789") != strlen(port) || atol(port) < 1 || atol(port) > 65535)) {
        snprintf(advice, SSV_ADVICE_SIZE, "'%s' is no port, which is 1 to 65535, as in " EXAMPLE, port);
    } else {
        snprintf(advice, SSV_ADVICE_SIZE,
                 "for UDP multicast the machine needs a route, e.g. ip route add 224.0.0.0/4 dev lo");
    }
}

void ssv_address_advice(const char* url, char advice[SSV_ADVICE_SIZE]) {
    if (is_provider(url, "udpm")) {
        advise_on_multicast(url + strlen("udpm://"), advice);
    } else if (is_provider(url, "tcpq")) {
        snprintf(advice, SSV_ADVICE_SIZE, "no LCM server answers there; lcm-tcpq-server is one, on port 7700");
    } else {
        snprintf(advice, SSV_ADVICE_SIZE, "an address reads " EXAMPLE " (multicast) or tcpq://HOST:7700 (a server)");
    }
}
