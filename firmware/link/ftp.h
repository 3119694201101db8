/// Numbers of the file-transfer microservice, and the vehicle's four files.
#ifndef SSV_LINK_FTP_H
#define SSV_LINK_FTP_H

typedef enum {
    SSV_FTP_TERMINATE = 1,
    SSV_FTP_RESET = 2,
    SSV_FTP_OPEN_READ = 4,
    SSV_FTP_READ = 5,
    SSV_FTP_CREATE = 6,
    SSV_FTP_WRITE = 7,
    SSV_FTP_REMOVE = 8,
    SSV_FTP_OPEN_WRITE = 11,
    SSV_FTP_TRUNCATE = 12,
    SSV_FTP_RENAME = 13,
    SSV_FTP_CRC = 14,
    SSV_FTP_BURST = 15,
    SSV_FTP_ACK = 128,
    SSV_FTP_NAK = 129
} ssv_ftp_opcode_t;

typedef enum {
    SSV_FTP_OK = 0,
    SSV_FTP_BAD_SIZE = 3,
    SSV_FTP_BAD_SESSION = 4,
    SSV_FTP_NO_SESSION_LEFT = 5,
    SSV_FTP_END_OF_FILE = 6,
    SSV_FTP_UNKNOWN = 7,
    SSV_FTP_PROTECTED = 9,
    SSV_FTP_NOT_FOUND = 10
} ssv_ftp_error_t;

#define SSV_FTP_INCOMING_PATH "/plan/incoming"
#define SSV_FTP_LIVE_PATH "/plan/live"
#define SSV_FTP_HEADER_PATH "/plan/header"
#define SSV_FTP_LOG_PATH "/log/events"

#endif
