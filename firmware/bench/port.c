#define _DEFAULT_SOURCE
#include "bench/port.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

static bool fail(char* error, size_t error_size, const char* where, const char* why) {
    (void)snprintf(error, error_size, "%s: %s", where, why);
    return false;
}

// A number up to `most`; 0 for none.
static long number(const char* text, long most) {
    char* end;
    const long value = strtol(text, &end, 10);
    return end != text && *end == '\0' && value > 0 && value <= most ? value : 0;
}

static bool open_udp(port_t* port, const char* where, const char* address, char* error, size_t error_size) {
    char host[64];
    const char* colon = strrchr(address, ':');
    const long number_of_port = colon == NULL ? 0 : number(colon + 1, 65535);
    if (number_of_port == 0 || (size_t)(colon - address) >= sizeof host)
        return fail(error, error_size, where, "should be udp:ADDRESS:PORT");
    (void)snprintf(host, sizeof host, "%.*s", (int)(colon - address), address);
    port->peer = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)number_of_port)};
    if (inet_pton(AF_INET, host, &port->peer.sin_addr) != 1)
        return fail(error, error_size, where, "the address is no IPv4 address, such as 127.0.0.1");
    port->has_peer = true;
    port->fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (port->fd < 0 || connect(port->fd, (struct sockaddr*)&port->peer, sizeof port->peer) != 0)
        return fail(error, error_size, where, strerror(errno));
    return true;
}

static bool open_listening(port_t* port, const char* where, const char* text, char* error, size_t error_size) {
    const long number_of_port = number(text, 65535);
    if (number_of_port == 0 && strcmp(text, "0") != 0)
        return fail(error, error_size, where, "should be udp-listen:PORT");
    const struct sockaddr_in own = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)number_of_port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    port->listens = true;
    port->fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (port->fd < 0 || bind(port->fd, (const struct sockaddr*)&own, sizeof own) != 0)
        return fail(error, error_size, where, strerror(errno));
    return true;
}

static bool open_serial(port_t* port, const char* where, const char* text, char* error, size_t error_size) {
    static const struct {
        long baud;
        speed_t speed;
    } speeds[] = {{9600, B9600},     {57600, B57600},   {115200, B115200},
                  {230400, B230400}, {460800, B460800}, {921600, B921600}};
    char device[256];
    const char* colon = strrchr(text, ':');
    const long baud = colon == NULL ? 0 : number(colon + 1, 10000000);
    struct termios line;
    for (size_t i = 0; i < sizeof speeds / sizeof *speeds; i++) {
        if (speeds[i].baud != baud || (size_t)(colon - text) >= sizeof device) continue;
        (void)snprintf(device, sizeof device, "%.*s", (int)(colon - text), text);
        port->is_serial = port->has_peer = true;
        port->fd = open(device, O_RDWR | O_NOCTTY | O_NONBLOCK);
        if (port->fd < 0 || tcgetattr(port->fd, &line) != 0) return fail(error, error_size, where, strerror(errno));
        cfmakeraw(&line);
        cfsetispeed(&line, speeds[i].speed);
        cfsetospeed(&line, speeds[i].speed);
        line.c_cflag |= CLOCAL | CREAD;
        return tcsetattr(port->fd, TCSANOW, &line) == 0 || fail(error, error_size, where, strerror(errno));
    }
    return fail(error, error_size, where,
                "should be serial:DEVICE:BAUD with 9600, 57600, 115200, 230400, 460800 or 921600 baud");
}

bool port_open(port_t* port, const char* where, char* error, size_t error_size) {
    memset(port, 0, sizeof *port);
    port->fd = -1;
    bool opened = false;
    if (strncmp(where, "udp:", 4) == 0)
        opened = open_udp(port, where, where + 4, error, error_size);
    else if (strncmp(where, "udp-listen:", 11) == 0)
        opened = open_listening(port, where, where + 11, error, error_size);
    else if (strncmp(where, "serial:", 7) == 0)
        opened = open_serial(port, where, where + 7, error, error_size);
    else
        return fail(error, error_size, where, "should begin with udp:, udp-listen: or serial:");
    if (!opened) port_close(port);
    return opened;
}

size_t port_read(port_t* port, int wait_ms, uint8_t* bytes, size_t capacity) {
    struct pollfd wait = {.fd = port->fd, .events = POLLIN};
    if (poll(&wait, 1, wait_ms) <= 0) return 0;
    ssize_t got;
    if (port->listens) {
        struct sockaddr_in from;
        socklen_t size = sizeof from;
        got = recvfrom(port->fd, bytes, capacity, 0, (struct sockaddr*)&from, &size);
        if (got > 0) {
            port->peer = from;
            port->has_peer = true;
        }
    } else {
        got = read(port->fd, bytes, capacity);
    }
    return got > 0 ? (size_t)got : 0;
}

void port_write(port_t* port, const uint8_t* bytes, size_t num_bytes) {
    if (!port->has_peer) return;
    const ssize_t sent = port->listens ? sendto(port->fd, bytes, num_bytes, MSG_DONTWAIT,
                                                (const struct sockaddr*)&port->peer, sizeof port->peer)
                                       : write(port->fd, bytes, num_bytes);
    (void)sent;
}

int port_number(const port_t* port) {
    struct sockaddr_in own;
    socklen_t size = sizeof own;
    return getsockname(port->fd, (struct sockaddr*)&own, &size) == 0 ? ntohs(own.sin_port) : 0;
}

void port_close(port_t* port) {
    if (port->fd >= 0) close(port->fd);
    port->fd = -1;
}
