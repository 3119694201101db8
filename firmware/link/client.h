/// The planner's file client: it uploads one timeline, whatever gets lost on the way.
///
/// Up to SSV_LINK_WINDOW chunks wait for their answers at a time. One is sent again when answers to three later ones
/// came before its own, or when it waited for longer than round trips take; each further wait is twice as long. A
/// request that is sent again keeps its sequence number, so the vehicle knows it. When the vehicle has closed the
/// session the client opens the file again and goes on with what is missing; when the vehicle has forgotten the file,
/// or its CRC-32 is another one in the end, it begins anew. All of it is bounded: tries of a request, and new
/// beginnings.
#ifndef SSV_LINK_CLIENT_H
#define SSV_LINK_CLIENT_H

#include "link/wire.h"

typedef enum { SSV_CLIENT_BUSY, SSV_CLIENT_DONE, SSV_CLIENT_FAILED } ssv_client_outcome_t;

void ssv_client_begin(ssv_link_client_t* client, const uint8_t* file, size_t length, uint8_t chunk_bytes);

/// Takes an answer. SSV_CLIENT_FAILED comes with a reason.
ssv_client_outcome_t ssv_client_answer(ssv_link_client_t* client, int64_t now_us, const ssv_ftp_t* answer,
                                       uint8_t chunk_bytes, ssv_link_reason_t* reason);

/// The next request to send; false when none is due.
bool ssv_client_poll(ssv_link_client_t* client, int64_t now_us, uint8_t chunk_bytes, ssv_ftp_t* request);

/// SSV_CLIENT_FAILED once a request was tried too often; then the client is idle.
ssv_client_outcome_t ssv_client_watch(ssv_link_client_t* client, int64_t now_us);

#endif
