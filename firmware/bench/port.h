/// Where the link's bytes come from and go to: a UDP socket or a serial port.
#ifndef BENCH_PORT_H
#define BENCH_PORT_H

#include <netinet/in.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    int fd;
    bool is_serial;
    bool listens; ///< a socket that answers whoever spoke last
    bool has_peer;
    struct sockaddr_in peer;
} port_t;

/// Opens "udp:ADDRESS:PORT", which sends there and hears from there alone; "udp-listen:PORT", on the loopback alone,
/// which answers whoever spoke last; or "serial:DEVICE:BAUD".
/// @return false with a sentence in `error`.
bool port_open(port_t* port, const char* where, char* error, size_t error_size);

/// Waits at most so long for bytes. @return how many came.
size_t port_read(port_t* port, int wait_ms, uint8_t* bytes, size_t capacity);

/// What cannot be sent now is lost, as on a radio.
void port_write(port_t* port, const uint8_t* bytes, size_t num_bytes);

/// The number of the UDP port that it listens on.
int port_number(const port_t* port);

void port_close(port_t* port);

#endif
