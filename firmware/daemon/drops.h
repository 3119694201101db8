/// How many datagrams the kernel has thrown away because this process did not fetch them in time.
#ifndef SSV_DROPS_H
#define SSV_DROPS_H

#include <stdint.h>

/// The sum over all UDP sockets of this process, from /proc (Linux); -1 where that cannot be told. Costs some tens of
/// microseconds per open descriptor: call it once a second, not per datagram.
int64_t drops_count(void);

#endif
