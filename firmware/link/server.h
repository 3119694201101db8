/// The vehicle's file server: four files with fixed names, one session. Any client may fail here, none can do harm:
/// only the incoming timeline can be written, and nothing here makes it the live one.
#ifndef SSV_LINK_SERVER_H
#define SSV_LINK_SERVER_H

#include "link/wire.h"

/// Takes a request. Its answer comes from ssv_server_poll; when too many wait the request is passed over, as if lost.
void ssv_server_request(ssv_link_vehicle_t* link, int64_t now_us, const ssv_packet_t* request);

/// The next answer, or frame of a burst; false when there is none.
bool ssv_server_poll(ssv_link_vehicle_t* link, int64_t now_us, ssv_packet_t* answer);

/// Ends the session and forgets what waits to be sent: the files are about to be others.
void ssv_server_close(ssv_link_server_t* server);

#endif
