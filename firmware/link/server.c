// The vehicle's file server.
#include "link/server.h"

#include "link/bytes.h"
#include "link/ftp.h"

/// [us] A session in which neither end did anything for so long is over.
#define SESSION_TIMEOUT_US INT64_C(30000000)

enum { NO_FILE, INCOMING, LIVE, HEADER, EVENT_LOG };

typedef struct {
    const uint8_t* bytes; ///< null where there is no such file now
    uint32_t length;
} file_t;

static uint8_t file_named(const ssv_ftp_t* request) {
    static const struct {
        const char* path;
        uint8_t file;
    } files[] = {{SSV_FTP_INCOMING_PATH, INCOMING},
                 {SSV_FTP_LIVE_PATH, LIVE},
                 {SSV_FTP_HEADER_PATH, HEADER},
                 {SSV_FTP_LOG_PATH, EVENT_LOG}};
    size_t length = request->size;
    if (length > 0 && request->data[length - 1] == '\0') length--; // some clients send the zero at the end, too
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (strlen(files[i].path) == length && memcmp(files[i].path, request->data, length) == 0) return files[i].file;
    }
    return NO_FILE;
}

static file_t content_of(const ssv_link_vehicle_t* link, uint8_t file) {
    const uint8_t live = link->live, incoming = live ^ 1;
    switch (file) {
        case INCOMING: return (file_t){link->incoming ? link->image[incoming] : NULL, link->length[incoming]};
        case LIVE: return (file_t){link->length[live] > 0 ? link->image[live] : NULL, link->length[live]};
        case HEADER: return (file_t){link->length[live] > 0 ? link->image[live] : NULL, SSV_TIMELINE_HEADER_BYTES};
        case EVENT_LOG: return (file_t){link->log, link->log_length};
        default: return (file_t){NULL, 0};
    }
}

void ssv_server_close(ssv_link_server_t* server) {
    server->open = false;
    server->burst = false;
    server->has_last = false;
    server->num_answers = 0;
}

static void queue(ssv_link_server_t* server, const ssv_link_answer_t* answer) {
    if (server->num_answers == SSV_LINK_MAX_ANSWERS) return;
    server->answer[(server->first_answer + server->num_answers) % SSV_LINK_MAX_ANSWERS] = *answer;
    server->num_answers++;
}

static ssv_ftp_error_t set_number(ssv_link_answer_t* answer, uint32_t number) {
    answer->size = 4;
    ssv_put_u32(answer->data, number);
    return SSV_FTP_OK;
}

// Opens a session for the sender of the request, unless somebody else's is alive. Its number is the one in the request:
// pymavlink's client does not wait for the answer to CreateFile when that takes longer than 0.1 s, and its first chunks
// have that number.
static ssv_ftp_error_t open_session(ssv_link_server_t* server, const ssv_packet_t* request, uint8_t file) {
    if (server->open && (server->sysid != request->sysid || server->compid != request->compid))
        return SSV_FTP_NO_SESSION_LEFT;
    server->open = true;
    server->burst = false;
    server->session = request->of.ftp.session;
    server->file = file;
    server->sysid = request->sysid;
    server->compid = request->compid;
    return SSV_FTP_OK;
}

static ssv_ftp_error_t open_existing(ssv_link_vehicle_t* link, const ssv_packet_t* request, ssv_link_answer_t* answer) {
    const uint8_t file = file_named(&request->of.ftp);
    const file_t content = content_of(link, file);
    if (content.bytes == NULL) return SSV_FTP_NOT_FOUND;
    if ((file == INCOMING) != (request->of.ftp.opcode == SSV_FTP_OPEN_WRITE)) return SSV_FTP_PROTECTED;
    const ssv_ftp_error_t error = open_session(&link->server, request, file);
    return error != SSV_FTP_OK ? error : set_number(answer, content.length);
}

static ssv_ftp_error_t create(ssv_link_vehicle_t* link, int64_t now_us, const ssv_packet_t* request) {
    const uint8_t incoming = link->live ^ 1;
    if (file_named(&request->of.ftp) != INCOMING) return SSV_FTP_PROTECTED;
    const ssv_ftp_error_t error = open_session(&link->server, request, INCOMING);
    if (error != SSV_FTP_OK) return error;
    memset(link->image[incoming], 0, sizeof link->image[incoming]);
    link->incoming = true;
    link->length[incoming] = 0;
    link->begun_us[incoming] = now_us;
    return SSV_FTP_OK;
}

static bool is_in_session(const ssv_link_server_t* server, const ssv_packet_t* request) {
    return server->open && server->sysid == request->sysid && server->compid == request->compid &&
           server->session == request->of.ftp.session;
}

static ssv_ftp_error_t write_chunk(ssv_link_vehicle_t* link, const ssv_packet_t* request) {
    const ssv_ftp_t* ftp = &request->of.ftp;
    const uint8_t incoming = link->live ^ 1;
    if (!is_in_session(&link->server, request) || link->server.file != INCOMING) return SSV_FTP_BAD_SESSION;
    if (ftp->size == 0 || ftp->offset > SSV_TIMELINE_FILE_BYTES_MAX - (uint32_t)ftp->size) return SSV_FTP_BAD_SIZE;
    memcpy(link->image[incoming] + ftp->offset, ftp->data, ftp->size);
    if (link->length[incoming] < ftp->offset + ftp->size) link->length[incoming] = ftp->offset + ftp->size;
    return SSV_FTP_OK;
}

// Both read requests; the data are taken when the answer is sent.
static ssv_ftp_error_t read_chunk(ssv_link_vehicle_t* link, const ssv_packet_t* request, ssv_link_answer_t* answer) {
    ssv_link_server_t* server = &link->server;
    const ssv_ftp_t* ftp = &request->of.ftp;
    if (!is_in_session(server, request) || server->file == INCOMING) return SSV_FTP_BAD_SESSION;
    const file_t content = content_of(link, server->file);
    if (ftp->offset >= content.length) return SSV_FTP_END_OF_FILE;
    const uint32_t left = content.length - ftp->offset;
    const uint8_t size = ftp->size > 0 ? ftp->size : SSV_FTP_DATA_BYTES_MAX;
    answer->file = server->file;
    answer->size = left < size ? (uint8_t)left : size;
    return SSV_FTP_OK;
}

static ssv_ftp_error_t end_session(ssv_link_server_t* server, const ssv_packet_t* request) {
    const bool is_theirs = server->open && server->sysid == request->sysid && server->compid == request->compid;
    const bool is_it = is_in_session(server, request);
    if (request->of.ftp.opcode == SSV_FTP_TERMINATE && !is_it) return SSV_FTP_BAD_SESSION;
    if (is_theirs) {
        server->open = false;
        server->burst = false;
    }
    return SSV_FTP_OK;
}

static ssv_ftp_error_t crc_of_file(const ssv_link_vehicle_t* link, const ssv_packet_t* request,
                                   ssv_link_answer_t* answer) {
    const file_t content = content_of(link, file_named(&request->of.ftp));
    if (content.bytes == NULL) return SSV_FTP_NOT_FOUND;
    return set_number(answer, ssv_crc32_of_ftp(content.bytes, content.length));
}

static ssv_ftp_error_t serve(ssv_link_vehicle_t* link, int64_t now_us, const ssv_packet_t* request,
                             ssv_link_answer_t* answer) {
    switch (request->of.ftp.opcode) {
        case SSV_FTP_TERMINATE:
        case SSV_FTP_RESET: return end_session(&link->server, request);
        case SSV_FTP_OPEN_READ:
        case SSV_FTP_OPEN_WRITE: return open_existing(link, request, answer);
        case SSV_FTP_CREATE: return create(link, now_us, request);
        case SSV_FTP_WRITE: return write_chunk(link, request);
        case SSV_FTP_READ:
        case SSV_FTP_BURST: return read_chunk(link, request, answer);
        case SSV_FTP_CRC: return crc_of_file(link, request, answer);
        case SSV_FTP_REMOVE:
        case SSV_FTP_TRUNCATE:
        case SSV_FTP_RENAME: // a rename must not be a way to commit
            return SSV_FTP_PROTECTED;
        default: return SSV_FTP_UNKNOWN;
    }
}

// Requests that would do something else the second time.
static bool changes_session(uint8_t opcode) {
    return opcode == SSV_FTP_CREATE || opcode == SSV_FTP_OPEN_READ || opcode == SSV_FTP_OPEN_WRITE ||
           opcode == SSV_FTP_TERMINATE || opcode == SSV_FTP_RESET;
}

static bool is_repeated(const ssv_link_server_t* server, const ssv_packet_t* request, uint32_t crc) {
    const ssv_ftp_t* ftp = &request->of.ftp;
    const ssv_link_answer_t* last = &server->last;
    if (!server->has_last || last->sysid != request->sysid || last->compid != request->compid ||
        last->sequence != (uint16_t)(ftp->sequence + 1) || last->request != ftp->opcode || server->last_crc != crc)
        return false;
    // What opened a session that is over must open another one.
    const bool opened = ftp->opcode != SSV_FTP_TERMINATE && ftp->opcode != SSV_FTP_RESET && last->opcode == SSV_FTP_ACK;
    return !opened || (server->open && server->session == last->session);
}

void ssv_server_request(ssv_link_vehicle_t* link, int64_t now_us, const ssv_packet_t* request) {
    ssv_link_server_t* server = &link->server;
    const ssv_ftp_t* ftp = &request->of.ftp;
    if (ftp->opcode >= SSV_FTP_ACK || server->num_answers == SSV_LINK_MAX_ANSWERS) return;
    if (server->open && now_us - server->active_us > SESSION_TIMEOUT_US) server->open = server->burst = false;
    const uint32_t crc = ssv_crc32(0, ftp->data, ftp->size);
    if (is_repeated(server, request, crc)) {
        queue(server, &server->last);
        return;
    }
    ssv_link_answer_t answer = {.sysid = request->sysid,
                                .compid = request->compid,
                                .sequence = (uint16_t)(ftp->sequence + 1),
                                .session = ftp->session,
                                .opcode = SSV_FTP_ACK,
                                .request = ftp->opcode,
                                .file = NO_FILE,
                                .offset = ftp->offset};
    const ssv_ftp_error_t error = serve(link, now_us, request, &answer);
    if (error != SSV_FTP_OK) {
        answer.opcode = SSV_FTP_NAK;
        answer.size = 1;
        answer.data[0] = (uint8_t)error;
    }
    if (is_in_session(server, request) || changes_session(ftp->opcode)) server->active_us = now_us;
    if (changes_session(ftp->opcode)) {
        server->has_last = true;
        server->last = answer;
        server->last_crc = crc;
    }
    if (error == SSV_FTP_OK && ftp->opcode == SSV_FTP_BURST) {
        server->burst = true;
        server->next_of_burst = answer;
        server->next_of_burst.size = ftp->size > 0 ? ftp->size : SSV_FTP_DATA_BYTES_MAX;
    } else {
        queue(server, &answer);
    }
}

static void fill(const ssv_link_vehicle_t* link, const ssv_link_answer_t* answer, ssv_packet_t* packet) {
    const file_t content = content_of(link, answer->file);
    packet->kind = SSV_PACKET_FTP;
    packet->target_sysid = answer->sysid;
    packet->target_compid = answer->compid;
    packet->of.ftp.sequence = answer->sequence;
    packet->of.ftp.session = answer->session;
    packet->of.ftp.opcode = answer->opcode;
    packet->of.ftp.request = answer->request;
    packet->of.ftp.size = answer->size;
    packet->of.ftp.last_of_burst = answer->last_of_burst;
    packet->of.ftp.offset = answer->offset;
    if (answer->file == NO_FILE) {
        memcpy(packet->of.ftp.data, answer->data, sizeof answer->data);
        return;
    }
    // The log may have become shorter since the request.
    const uint32_t left = answer->offset < content.length ? content.length - answer->offset : 0;
    if (left < answer->size) packet->of.ftp.size = (uint8_t)left;
    if (left > 0 && content.bytes != NULL) {
        memcpy(packet->of.ftp.data, content.bytes + answer->offset, packet->of.ftp.size);
    }
}

bool ssv_server_poll(ssv_link_vehicle_t* link, int64_t now_us, ssv_packet_t* packet) {
    ssv_link_server_t* server = &link->server;
    if (server->num_answers > 0) {
        fill(link, &server->answer[server->first_answer], packet);
        server->first_answer = (server->first_answer + 1) % SSV_LINK_MAX_ANSWERS;
        server->num_answers--;
    } else if (server->burst) {
        ssv_link_answer_t* next = &server->next_of_burst;
        const file_t content = content_of(link, next->file);
        next->last_of_burst = next->offset + next->size >= content.length;
        fill(link, next, packet);
        server->burst = !next->last_of_burst;
        next->offset += next->size;
        next->sequence++;
    } else {
        return false;
    }
    if (server->open && server->sysid == packet->target_sysid && server->compid == packet->target_compid)
        server->active_us = now_us;
    return true;
}
