// The planner's file client.
#include "link/client.h"

#include "link/bytes.h"
#include "link/ftp.h"

/// At 20 % loss each way an exchange fails with 0.36: 30 tries in a row with 5e-14.
#define TRIES_MAX 30
#define RESTARTS_MAX 4
/// [us] Patience before the first round trip is known, and its bounds after.
#define PATIENCE_FIRST_US INT64_C(500000)
#define PATIENCE_MIN_US INT64_C(100000)
#define PATIENCE_MAX_US INT64_C(4000000)
/// Answers to so many later requests say that this one is lost.
#define OVERTAKEN 3

enum { IDLE, CREATE, WRITE, REOPEN, CHECK, END };

static uint8_t num_chunks(uint32_t length, uint8_t chunk_bytes) {
    return (uint8_t)((length + chunk_bytes - 1) / chunk_bytes);
}

// All stages but WRITE have one request, in the first slot.
static void enter(ssv_link_client_t* client, uint8_t stage) {
    client->stage = stage;
    memset(client->request, 0, sizeof client->request);
    if (stage == IDLE || stage == WRITE) return;
    client->request[0].used = client->request[0].due = true;
    client->request[0].sequence = client->next_sequence++;
}

static void begin_anew(ssv_link_client_t* client) {
    memset(client->acked, 0, sizeof client->acked);
    client->num_acked = 0;
    client->next_chunk = 0;
    enter(client, CREATE);
}

void ssv_client_begin(ssv_link_client_t* client, const uint8_t* file, size_t length, uint8_t chunk_bytes) {
    client->file = file;
    client->length = (uint32_t)length;
    client->crc = ssv_crc32_of_ftp(file, length);
    client->num_chunks = num_chunks(client->length, chunk_bytes);
    client->restarts = 0;
    begin_anew(client);
}

static void learn_round_trip(ssv_link_client_t* client, int64_t sample_us) {
    if (client->round_trip_us == 0) {
        client->round_trip_us = sample_us;
        client->deviation_us = sample_us / 2;
        return;
    }
    const int64_t error_us = sample_us - client->round_trip_us;
    client->deviation_us += ((error_us < 0 ? -error_us : error_us) - client->deviation_us) / 4;
    client->round_trip_us += error_us / 8;
}

static int64_t patience_us(const ssv_link_client_t* client) {
    if (client->round_trip_us == 0) return PATIENCE_FIRST_US;
    const int64_t us = client->round_trip_us + 4 * client->deviation_us;
    return us < PATIENCE_MIN_US ? PATIENCE_MIN_US : us > PATIENCE_MAX_US ? PATIENCE_MAX_US : us;
}

static ssv_link_request_t* request_answered(ssv_link_client_t* client, const ssv_ftp_t* answer) {
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        ssv_link_request_t* request = &client->request[i];
        if (request->used && request->tries > 0 && (uint16_t)(request->sequence + 1) == answer->sequence)
            return request;
    }
    return NULL;
}

static ssv_client_outcome_t fail(ssv_link_client_t* client, ssv_link_reason_t why, ssv_link_reason_t* reason) {
    enter(client, IDLE);
    *reason = why;
    return SSV_CLIENT_FAILED;
}

static ssv_client_outcome_t restart(ssv_link_client_t* client, ssv_link_reason_t why, ssv_link_reason_t* reason) {
    if (client->restarts++ == RESTARTS_MAX) return fail(client, why, reason);
    begin_anew(client);
    return SSV_CLIENT_BUSY;
}

static ssv_client_outcome_t refused(ssv_link_client_t* client, ssv_link_request_t* request, const ssv_ftp_t* answer,
                                    ssv_link_reason_t* reason) {
    const uint8_t error = answer->size > 0 ? answer->data[0] : 0;
    switch (client->stage) {
        case WRITE:
            if (error != SSV_FTP_BAD_SESSION) return fail(client, SSV_LINK_LENGTH, reason);
            enter(client, REOPEN);
            return SSV_CLIENT_BUSY;
        case END: // the file is there and checked; the session ends by itself
            enter(client, IDLE);
            return SSV_CLIENT_BUSY;
        default:
            if (error == SSV_FTP_NO_SESSION_LEFT) { // somebody else's: wait as if this answer were lost
                request->sequence = client->next_sequence++;
                return SSV_CLIENT_BUSY;
            }
            return restart(client, SSV_LINK_NOTHING, reason);
    }
}

static void acknowledge_chunk(ssv_link_client_t* client, ssv_link_request_t* request) {
    client->acked[request->chunk / 32] |= UINT32_C(1) << request->chunk % 32;
    client->num_acked++;
    request->used = false;
    // The line keeps the order: what was sent before and is not answered is lost.
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        ssv_link_request_t* other = &client->request[i];
        if (other->used && other->tries > 0 && (int32_t)(request->order - other->order) >= OVERTAKEN) other->due = true;
    }
    if (client->num_acked == client->num_chunks) enter(client, CHECK);
}

ssv_client_outcome_t ssv_client_answer(ssv_link_client_t* client, int64_t now_us, const ssv_ftp_t* answer,
                                       uint8_t chunk_bytes, ssv_link_reason_t* reason) {
    static const uint8_t opcode[] = {0,           SSV_FTP_CREATE,   SSV_FTP_WRITE, SSV_FTP_OPEN_WRITE,
                                     SSV_FTP_CRC, SSV_FTP_TERMINATE};
    ssv_link_request_t* request = client->stage == IDLE ? NULL : request_answered(client, answer);
    if (request == NULL || answer->request != opcode[client->stage])
        return SSV_CLIENT_BUSY; // late, or of somebody else
    // No more than one chunk may be claimed by an answer, and it must be the one that was sent.
    if (client->stage == WRITE && answer->offset != (uint32_t)request->chunk * chunk_bytes) return SSV_CLIENT_BUSY;
    if (request->tries == 1) learn_round_trip(client, now_us - request->sent_us);
    if (answer->opcode == SSV_FTP_NAK) return refused(client, request, answer, reason);
    if (answer->opcode != SSV_FTP_ACK) return SSV_CLIENT_BUSY;
    switch (client->stage) {
        case CREATE:
        case REOPEN:
            client->session = answer->session;
            enter(client, client->num_acked == client->num_chunks ? CHECK : WRITE);
            return SSV_CLIENT_BUSY;
        case WRITE: acknowledge_chunk(client, request); return SSV_CLIENT_BUSY;
        case CHECK:
            if (answer->size != 4 || ssv_get_u32(answer->data) != client->crc)
                return restart(client, SSV_LINK_CRC, reason);
            enter(client, END);
            return SSV_CLIENT_DONE;
        default: enter(client, IDLE); return SSV_CLIENT_BUSY;
    }
}

static bool is_waiting(const ssv_link_client_t* client, uint8_t chunk) {
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        if (client->request[i].used && client->request[i].chunk == chunk) return true;
    }
    return false;
}

static bool is_acked(const ssv_link_client_t* client, uint8_t chunk) {
    return (client->acked[chunk / 32] >> chunk % 32 & 1) != 0;
}

// Gives a free slot the next chunk that nobody has answered and nobody waits for.
static void fill_window(ssv_link_client_t* client) {
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        ssv_link_request_t* request = &client->request[i];
        if (request->used) continue;
        for (uint8_t k = 0; k < client->num_chunks; k++) {
            const uint8_t chunk = (uint8_t)((client->next_chunk + k) % client->num_chunks);
            if (is_acked(client, chunk) || is_waiting(client, chunk)) continue;
            *request = (ssv_link_request_t){.used = true, .due = true, .chunk = chunk};
            request->sequence = client->next_sequence++;
            client->next_chunk = (uint8_t)((chunk + 1) % client->num_chunks);
            break;
        }
        if (!request->used) return;
    }
}

static ssv_link_request_t* request_due(ssv_link_client_t* client, int64_t now_us) {
    ssv_link_request_t* first = NULL;
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        ssv_link_request_t* request = &client->request[i];
        if (request->used && request->tries > 0 && now_us - request->sent_us >= request->patience_us)
            request->due = true;
        // What was lost goes first, then in the order of the file.
        if (request->used && request->due && request->tries < TRIES_MAX &&
            (first == NULL || (int16_t)(request->sequence - first->sequence) < 0))
            first = request;
    }
    return first;
}

static void set_path(ssv_ftp_t* request, const char* path) {
    request->size = (uint8_t)strlen(path);
    memcpy(request->data, path, request->size);
}

static void write_request(const ssv_link_client_t* client, const ssv_link_request_t* from, uint8_t chunk_bytes,
                          ssv_ftp_t* request) {
    request->sequence = from->sequence;
    request->session = client->session;
    request->request = request->last_of_burst = request->size = 0;
    request->offset = 0;
    switch (client->stage) {
        case CREATE:
            request->opcode = SSV_FTP_CREATE;
            set_path(request, SSV_FTP_INCOMING_PATH);
            break;
        case REOPEN:
            request->opcode = SSV_FTP_OPEN_WRITE;
            set_path(request, SSV_FTP_INCOMING_PATH);
            break;
        case CHECK:
            request->opcode = SSV_FTP_CRC;
            set_path(request, SSV_FTP_INCOMING_PATH);
            break;
        case END: request->opcode = SSV_FTP_TERMINATE; break;
        default:
            request->opcode = SSV_FTP_WRITE;
            request->offset = (uint32_t)from->chunk * chunk_bytes;
            request->size = client->length - request->offset < chunk_bytes ? (uint8_t)(client->length - request->offset)
                                                                           : chunk_bytes;
            memcpy(request->data, client->file + request->offset, request->size);
            break;
    }
}

bool ssv_client_poll(ssv_link_client_t* client, int64_t now_us, uint8_t chunk_bytes, ssv_ftp_t* out) {
    if (client->stage == IDLE) return false;
    if (client->stage == WRITE) fill_window(client);
    ssv_link_request_t* request = request_due(client, now_us);
    if (request == NULL) return false;
    write_request(client, request, chunk_bytes, out);
    request->due = false;
    request->tries++;
    request->sent_us = now_us;
    request->order = ++client->order;
    // Each further wait of a request is twice as long.
    request->patience_us = request->tries == 1 ? patience_us(client) : 2 * request->patience_us;
    if (request->patience_us > PATIENCE_MAX_US) request->patience_us = PATIENCE_MAX_US;
    return true;
}

ssv_client_outcome_t ssv_client_watch(ssv_link_client_t* client, int64_t now_us) {
    for (int i = 0; i < SSV_LINK_WINDOW; i++) {
        const ssv_link_request_t* request = &client->request[i];
        if (!request->used || request->tries < TRIES_MAX || now_us - request->sent_us < request->patience_us) continue;
        const bool is_over = client->stage == END;
        enter(client, IDLE);
        return is_over ? SSV_CLIENT_BUSY : SSV_CLIENT_FAILED;
    }
    return SSV_CLIENT_BUSY;
}
