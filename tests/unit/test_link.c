// The rules of both ends, frame by frame: framing, signatures, statistics, file server, commit, commands.
#include <math.h>
#include <string.h>

#include "link/ftp.h"
#include "link/wire.h"
#include "two_ends.h"
#include "unity.h"

#define S INT64_C(1000000)

static ssv_link_vehicle_t vehicle;
static ssv_link_vehicle_state_t state;
static ssv_link_vehicle_event_t event;
static ssv_wire_t tool; // some other client's framing
static ssv_packet_t request, answer;
static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX], frame[SSV_LINK_FRAME_BYTES_MAX];
static size_t file_length;
static ssv_timeline_t timeline;
static int64_t now_us;

void setUp(void) {
    const ssv_link_vehicle_config_t config = default_vehicle();
    now_us = 0;
    ssv_link_vehicle_init(&vehicle, &config);
    ssv_wire_init(&tool, 255, 190, NULL);
    state = (ssv_link_vehicle_state_t){.may_swap = true, .pose = {.known = true, .q_IS = {1, 0, 0, 0}}};
    draw_seed(9);
    timeline = draw_timeline(20);
    const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};
    file_length = ssv_timeline_encode(&timeline, &stamp, file, sizeof file);
}
void tearDown(void) {}

// Whether this byte makes a packet, which is then in `answer`.
static bool hear(ssv_wire_t* wire, int64_t us, uint8_t byte) {
    ssv_wire_take(wire, byte);
    return ssv_wire_next(wire, us, &answer);
}

static void deliver(const uint8_t* bytes, size_t length) {
    for (size_t at = 0; at < length;) {
        at += ssv_link_vehicle_receive(&vehicle, now_us, &state, bytes + at, length - at, &event);
        if (event.kind != SSV_LINK_VEHICLE_NOTHING) TEST_ASSERT_EQUAL_size_t(length, at);
    }
}

// Sends the request of the tool and takes the vehicle's next packet of this kind.
static bool exchange(ssv_packet_kind_t kind) {
    request.target_sysid = request.target_compid = 1;
    deliver(frame, ssv_wire_send(&tool, now_us, &request, frame));
    for (size_t length; (length = ssv_link_vehicle_poll(&vehicle, now_us, &state, frame)) > 0;) {
        for (size_t i = 0; i < length; i++) {
            if (hear(&tool, now_us, frame[i]) && answer.kind == kind) return true;
        }
    }
    return false;
}

static uint8_t ftp(uint16_t sequence, uint8_t session, uint8_t opcode, uint32_t offset, const void* data, size_t size) {
    request = (ssv_packet_t){.kind = SSV_PACKET_FTP};
    request.of.ftp = (ssv_ftp_t){.sequence = sequence, .session = session, .opcode = opcode, .offset = offset};
    request.of.ftp.size = (uint8_t)size;
    if (data != NULL) memcpy(request.of.ftp.data, data, size);
    TEST_ASSERT_TRUE(exchange(SSV_PACKET_FTP));
    TEST_ASSERT_EQUAL_UINT16(sequence + 1, answer.of.ftp.sequence);
    TEST_ASSERT_EQUAL_UINT8(opcode, answer.of.ftp.request);
    return answer.of.ftp.opcode == SSV_FTP_ACK ? SSV_FTP_OK : answer.of.ftp.data[0];
}

static uint8_t path(uint16_t sequence, uint8_t opcode, const char* name) {
    return ftp(sequence, 0, opcode, 0, name, strlen(name));
}

static uint8_t command(uint16_t number, uint64_t plan_hash, float value) {
    request = (ssv_packet_t){.kind = SSV_PACKET_COMMAND};
    request.of.command.command = number;
    request.of.command.parameter[0] = value;
    request.of.command.x = (uint32_t)plan_hash;
    request.of.command.y = (uint32_t)(plan_hash >> 32);
    TEST_ASSERT_TRUE(exchange(SSV_PACKET_ACK));
    TEST_ASSERT_EQUAL_UINT16(number, answer.of.ack.command);
    return answer.of.ack.result;
}

static void upload(void) {
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(1, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH));
    const uint8_t session = answer.of.ftp.session;
    for (size_t at = 0; at < file_length; at += 200) {
        const size_t size = file_length - at < 200 ? file_length - at : 200;
        TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK,
                                ftp((uint16_t)(2 + at), session, SSV_FTP_WRITE, (uint32_t)at, file + at, size));
    }
}

static void make_file(void) {
    const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};
    file_length = ssv_timeline_encode(&timeline, &stamp, file, sizeof file);
}

static uint8_t commit(uint64_t plan_hash) {
    const uint8_t result = command(SSV_LINK_COMMIT, plan_hash, 0);
    return result == SSV_LINK_ACCEPTED ? SSV_LINK_NO_REASON : (uint8_t)answer.of.ack.detail;
}

// ---- Framing --------------------------------------------------------------------------------------------------------

static void test_every_flipped_bit_of_a_frame_is_counted_or_at_least_not_taken(void) {
    const ssv_packet_t heartbeat = {
        .kind = SSV_PACKET_BEAT, .target_sysid = 1, .target_compid = 1, .of.beat = {1, 2, 3}};
    request = heartbeat;
    const size_t length = ssv_wire_send(&tool, 0, &request, frame);
    for (size_t bit = 0; bit < 8 * length; bit++) {
        frame[bit / 8] ^= (uint8_t)(1 << bit % 8);
        deliver(frame, length);
        TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_NOTHING, event.kind);
        frame[bit / 8] ^= (uint8_t)(1 << bit % 8);
        static const uint8_t silence[300];
        deliver(silence, sizeof silence); // ends what a longer length would wait for
    }
    TEST_ASSERT_EQUAL_UINT32(0, vehicle.wire.statistics.received);
    TEST_ASSERT_TRUE(vehicle.wire.statistics.bad_crc > 8 * length / 2);
    deliver(frame, length);
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_BEAT, event.kind);
}

static int beats_heard(const uint8_t* bytes, size_t length) {
    int count = 0;
    for (size_t at = 0; at < length;) {
        at += ssv_link_vehicle_receive(&vehicle, 0, &state, bytes + at, length - at, &event);
        count += event.kind == SSV_LINK_VEHICLE_BEAT;
    }
    return count;
}

static void test_bytes_that_look_like_a_start_hide_no_frame(void) {
    // A false start that claims 255 bytes of payload, again and again, between frames that are good.
    static const uint8_t starts[][12] = {
        {0xfd, 255, 0, 0}, {0xfd, 255, 1, 0}, {0xfe, 255, 0, 0}, {0xfd, 3, 0x80}, {0xfd, 0xfd, 0}};
    static const uint8_t silence[400];
    int num_heard = 0;
    for (int k = 0; k < 100; k++) {
        num_heard += beats_heard(starts[k % 5], (size_t)(1 + k % 12));
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT, .of.beat.progress = (uint32_t)k};
        num_heard += beats_heard(frame, ssv_wire_send(&tool, 0, &request, frame));
    }
    num_heard += beats_heard(silence, sizeof silence);
    TEST_ASSERT_EQUAL_INT(100, num_heard);
    TEST_ASSERT_EQUAL_UINT32(0, vehicle.wire.statistics.lost);
}

static void test_losses_are_counted_per_peer_by_gaps_in_the_sequence_numbers(void) {
    ssv_wire_t other;
    ssv_wire_init(&other, 9, 9, NULL);
    for (int k = 0; k < 1000; k++) {
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
        const size_t length = ssv_wire_send(&tool, 0, &request, frame);
        if (k % 10 != 3) deliver(frame, length);
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
        deliver(frame, ssv_wire_send(&other, 0, &request, frame));
    }
    const ssv_link_statistics_t* statistics = &vehicle.wire.statistics;
    TEST_ASSERT_EQUAL_INT32(2, statistics->num_peers);
    TEST_ASSERT_EQUAL_UINT32(900, statistics->peer[0].received);
    TEST_ASSERT_EQUAL_UINT32(100, statistics->peer[0].lost);
    TEST_ASSERT_EQUAL_UINT32(1000, statistics->peer[1].received);
    TEST_ASSERT_EQUAL_UINT32(0, statistics->peer[1].lost);
    TEST_ASSERT_EQUAL_UINT32(100, statistics->lost);
}

static void test_a_frame_that_comes_twice_or_a_peer_that_begins_anew_is_no_loss(void) {
    for (int k = 0; k < 50; k++) {
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
        const size_t length = ssv_wire_send(&tool, 0, &request, frame);
        deliver(frame, length);
        deliver(frame, length);
    }
    TEST_ASSERT_EQUAL_UINT32(0, vehicle.wire.statistics.lost);
    ssv_wire_init(&tool, 255, 190, NULL); // its next number is 0 where 50 was expected
    request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
    deliver(frame, ssv_wire_send(&tool, 0, &request, frame));
    TEST_ASSERT_EQUAL_UINT32(0, vehicle.wire.statistics.lost);
}

static void test_more_peers_than_the_table_holds_are_heard_all_the_same(void) {
    for (uint8_t k = 0; k < 20; k++) {
        ssv_wire_init(&tool, (uint8_t)(10 + k), 1, NULL);
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
        deliver(frame, ssv_wire_send(&tool, 0, &request, frame));
        TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_BEAT, event.kind);
    }
    TEST_ASSERT_EQUAL_INT32(SSV_LINK_MAX_PEERS, vehicle.wire.statistics.num_peers);
}

static void test_what_is_for_another_system_or_component_is_passed_over(void) {
    const uint8_t targets[][3] = {{2, 1, 0}, {1, 2, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++) {
        request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
        request.target_sysid = targets[i][0];
        request.target_compid = targets[i][1];
        deliver(frame, ssv_wire_send(&tool, 0, &request, frame));
        TEST_ASSERT_EQUAL_INT(targets[i][2] == 1, event.kind == SSV_LINK_VEHICLE_BEAT);
    }
}

static void test_a_pose_comes_back_as_it_was_through_ned_and_frd(void) {
    ssv_wire_t receiver;
    ssv_wire_init(&receiver, 3, 3, NULL);
    const ssv_link_pose_t pose = {false, {1, 2, 3}, {0.5F, -0.5F, 0.1F, 0.7F}, {4, 5, 6}, {7, 8, 9}};
    const ssv_packet_kind_t kinds[] = {SSV_PACKET_ATTITUDE, SSV_PACKET_POSITION};
    for (int i = 0; i < 2; i++) {
        request = (ssv_packet_t){.kind = kinds[i], .of.pose = pose};
        const size_t length = ssv_wire_send(&tool, 0, &request, frame);
        bool got = false;
        for (size_t k = 0; k < length; k++) got = hear(&receiver, 0, frame[k]);
        TEST_ASSERT_TRUE(got);
        if (i == 0) {
            TEST_ASSERT_EQUAL_MEMORY(pose.q_IS, answer.of.pose.q_IS, sizeof pose.q_IS);
            TEST_ASSERT_EQUAL_MEMORY(pose.w_IS_S_rad_s, answer.of.pose.w_IS_S_rad_s, sizeof pose.w_IS_S_rad_s);
            // z of FRD points down: what turns about +z of S turns about -z of it.
            TEST_ASSERT_EQUAL_FLOAT(-9, *(const float*)(const void*)(memcpy(file, frame + 10 + 28, 4)));
        } else {
            TEST_ASSERT_EQUAL_MEMORY(pose.p_IS_m, answer.of.pose.p_IS_m, sizeof pose.p_IS_m);
            TEST_ASSERT_EQUAL_MEMORY(pose.v_IS_m_s, answer.of.pose.v_IS_m_s, sizeof pose.v_IS_m_s);
        }
    }
}

static void test_trims_that_are_no_numbers_are_not_taken(void) {
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        request = (ssv_packet_t){.kind = SSV_PACKET_TRIM};
        request.of.trim.trim_N[i] = (float)(1e308 * 10);
        deliver(frame, ssv_wire_send(&tool, 0, &request, frame));
        TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_NOTHING, event.kind);
        request = (ssv_packet_t){.kind = SSV_PACKET_TRIM};
        request.of.trim.trim_N[i] = -5;
        deliver(frame, ssv_wire_send(&tool, 0, &request, frame));
        TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_TRIM, event.kind);
        TEST_ASSERT_EQUAL_FLOAT(-5, event.of.trim.trim_N[i]);
    }
}

// ---- Signatures -----------------------------------------------------------------------------------------------------

static ssv_link_signing_t signing(uint8_t key, int64_t unix_zero_us) {
    ssv_link_signing_t made = {.unix_zero_us = unix_zero_us};
    memset(made.key, key, sizeof made.key);
    return made;
}

static void sign_vehicle(void) {
    ssv_link_vehicle_config_t config = default_vehicle();
    config.sign = true;
    config.signing = signing(1, EPOCH_US);
    ssv_link_vehicle_init(&vehicle, &config);
}

static bool hears(ssv_wire_t* sender, int64_t sender_us) {
    request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
    deliver(frame, ssv_wire_send(sender, sender_us, &request, frame));
    return event.kind == SSV_LINK_VEHICLE_BEAT;
}

static void test_only_what_is_signed_with_the_key_is_heard(void) {
    const ssv_link_signing_t same = signing(1, EPOCH_US), other = signing(2, EPOCH_US);
    sign_vehicle();
    TEST_ASSERT_FALSE(hears(&tool, 0));
    ssv_wire_init(&tool, 255, 190, &other);
    TEST_ASSERT_FALSE(hears(&tool, 0));
    TEST_ASSERT_EQUAL_UINT32(2, vehicle.wire.statistics.bad_signature);
    ssv_wire_init(&tool, 255, 190, &same);
    TEST_ASSERT_TRUE(hears(&tool, 0));
    TEST_ASSERT_TRUE(hears(&tool, 0));
    deliver(frame, 22 + 13 + 0); // part of a replay: then the whole of it
    setUp();
    sign_vehicle();
    ssv_wire_init(&tool, 255, 190, &same);
    request = (ssv_packet_t){.kind = SSV_PACKET_BEAT};
    const size_t length = ssv_wire_send(&tool, 0, &request, frame);
    deliver(frame, length);
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_BEAT, event.kind);
    deliver(frame, length);
    TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_LINK_VEHICLE_NOTHING, event.kind, "a replay");
}

static void test_a_new_sender_whose_clock_is_more_than_60_s_behind_is_refused(void) {
    const ssv_link_signing_t behind_59 = signing(1, EPOCH_US - 59 * S), behind_61 = signing(1, EPOCH_US - 61 * S);
    sign_vehicle();
    now_us = 1000 * S;
    ssv_wire_init(&tool, 255, 190, &behind_61);
    TEST_ASSERT_FALSE(hears(&tool, now_us));
    ssv_wire_init(&tool, 255, 190, &behind_59);
    TEST_ASSERT_TRUE(hears(&tool, now_us));
}

static void test_signatures_follow_the_clock_and_not_the_count_of_frames(void) {
    const ssv_link_signing_t same = signing(1, EPOCH_US);
    sign_vehicle();
    ssv_wire_init(&tool, 255, 190, &same);
    TEST_ASSERT_TRUE(hears(&tool, 0));
    // A sender that is silent for an hour and begins anew is neither late nor a replay.
    now_us = 3600 * S;
    ssv_wire_init(&tool, 255, 190, &same);
    TEST_ASSERT_TRUE(hears(&tool, now_us));
}

static void test_more_signing_senders_than_the_table_holds_are_refused_and_counted(void) {
    const ssv_link_signing_t same = signing(1, EPOCH_US);
    sign_vehicle();
    for (uint8_t k = 0; k < 6; k++) {
        ssv_wire_init(&tool, (uint8_t)(10 + k), 1, &same);
        TEST_ASSERT_EQUAL_INT(k < 4, hears(&tool, 0));
    }
    TEST_ASSERT_EQUAL_UINT32(2, vehicle.wire.statistics.refused_streams);
}

static void test_a_struct_that_was_moved_works_on(void) {
    static ssv_wire_t moved;
    const ssv_link_signing_t same = signing(1, EPOCH_US);
    sign_vehicle();
    ssv_wire_init(&tool, 255, 190, &same);
    moved = tool;
    memset(&tool, 0xff, sizeof tool);
    TEST_ASSERT_TRUE(hears(&moved, 0));
}

// ---- File server ----------------------------------------------------------------------------------------------------

static void test_no_write_without_a_session_and_none_into_somebody_else_s(void) {
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(1, 0, SSV_FTP_WRITE, 0, "x", 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(2, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH));
    const uint8_t session = answer.of.ftp.session;
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(3, session, SSV_FTP_WRITE, 0, "x", 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(4, (uint8_t)(session + 1), SSV_FTP_WRITE, 0, "x", 1));
    ssv_wire_init(&tool, 255, 191, NULL); // somebody else
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(5, session, SSV_FTP_WRITE, 0, "x", 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(5, session, SSV_FTP_TERMINATE, 0, NULL, 0));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(6, session, SSV_FTP_RESET, 0, NULL, 0));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_NO_SESSION_LEFT, path(7, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH));
    ssv_wire_init(&tool, 255, 190, NULL);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(8, session, SSV_FTP_WRITE, 1, "y", 1));
}

static void test_a_session_ends_after_30_s_in_which_neither_end_did_anything(void) {
    path(2, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH);
    const uint8_t session = answer.of.ftp.session;
    for (int k = 0; k < 5; k++) {
        now_us += 29 * S;
        TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp((uint16_t)(3 + k), session, SSV_FTP_WRITE, 0, "x", 1));
    }
    now_us += 31 * S;
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(9, session, SSV_FTP_WRITE, 0, "x", 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(10, SSV_FTP_OPEN_WRITE, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(1, answer.of.ftp.data[0], "what had arrived is still there");
}

static void test_a_client_that_does_not_wait_for_the_answer_to_create_is_served_by_the_number_it_proposed(void) {
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(1, 200, SSV_FTP_CREATE, 0, SSV_FTP_INCOMING_PATH, 14));
    TEST_ASSERT_EQUAL_UINT8(200, answer.of.ftp.session);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(2, 200, SSV_FTP_WRITE, 0, "x", 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(3, 201, SSV_FTP_CREATE, 0, SSV_FTP_INCOMING_PATH, 14));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(4, 200, SSV_FTP_WRITE, 0, "x", 1));
}

static void test_a_repeated_create_gets_the_same_answer_and_drops_nothing(void) {
    path(7, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH);
    const uint8_t session = answer.of.ftp.session;
    ftp(8, session, SSV_FTP_WRITE, 0, "abc", 3);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(7, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT8(session, answer.of.ftp.session);
    TEST_ASSERT_EQUAL_UINT32(3, vehicle.length[vehicle.live ^ 1]);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(9, session, SSV_FTP_TERMINATE, 0, NULL, 0));
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(SSV_FTP_OK, ftp(9, session, SSV_FTP_TERMINATE, 0, NULL, 0), "the same again");
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_BAD_SESSION, ftp(10, session, SSV_FTP_TERMINATE, 0, NULL, 0));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(11, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT32(0, vehicle.length[vehicle.live ^ 1]);
}

static void test_offsets_and_sizes_are_checked_before_use(void) {
    static const struct {
        uint32_t offset;
        size_t size;
        uint8_t error;
    } writes[] = {{SSV_TIMELINE_FILE_BYTES_MAX - 1, 1, SSV_FTP_OK},
                  {SSV_TIMELINE_FILE_BYTES_MAX - 1, 2, SSV_FTP_BAD_SIZE},
                  {SSV_TIMELINE_FILE_BYTES_MAX, 1, SSV_FTP_BAD_SIZE},
                  {UINT32_MAX, 1, SSV_FTP_BAD_SIZE},
                  {UINT32_MAX - 238, 239, SSV_FTP_BAD_SIZE},
                  {0, 0, SSV_FTP_BAD_SIZE},
                  {0, 239, SSV_FTP_OK}};
    static const uint8_t data[239];
    path(1, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH);
    const uint8_t session = answer.of.ftp.session;
    for (size_t i = 0; i < sizeof writes / sizeof *writes; i++)
        TEST_ASSERT_EQUAL_UINT8(
            writes[i].error, ftp((uint16_t)(10 + i), session, SSV_FTP_WRITE, writes[i].offset, data, writes[i].size));
}

static void test_names_have_their_own_rules(void) {
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_NOT_FOUND, path(1, SSV_FTP_OPEN_READ, SSV_FTP_LIVE_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_NOT_FOUND, path(2, SSV_FTP_CRC, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_NOT_FOUND, path(3, SSV_FTP_OPEN_WRITE, SSV_FTP_INCOMING_PATH));
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(4, SSV_FTP_OPEN_READ, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(5, SSV_FTP_CREATE, SSV_FTP_LIVE_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(6, SSV_FTP_CREATE, "/plan/incomin"));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(7, SSV_FTP_CREATE, ""));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(8, SSV_FTP_RENAME, SSV_FTP_INCOMING_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_PROTECTED, path(9, SSV_FTP_REMOVE, SSV_FTP_LIVE_PATH));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_UNKNOWN, path(10, 3, "/"));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(11, SSV_FTP_CRC, SSV_FTP_INCOMING_PATH));
    const uint32_t crc = (uint32_t)answer.of.ftp.data[0] | (uint32_t)answer.of.ftp.data[1] << 8 |
                         (uint32_t)answer.of.ftp.data[2] << 16 | (uint32_t)answer.of.ftp.data[3] << 24;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_NO_REASON, commit(timeline.plan_hash));
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(12, SSV_FTP_CRC, SSV_FTP_LIVE_PATH));
    TEST_ASSERT_EQUAL_MEMORY(&crc, answer.of.ftp.data, 4);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, path(13, SSV_FTP_OPEN_READ, SSV_FTP_HEADER_PATH));
    TEST_ASSERT_EQUAL_UINT8(96, answer.of.ftp.data[0]);
}

static void test_a_burst_reads_the_live_file_in_chunks_of_the_size_asked_for(void) {
    upload();
    commit(timeline.plan_hash);
    path(50, SSV_FTP_OPEN_READ, SSV_FTP_LIVE_PATH);
    request = (ssv_packet_t){.kind = SSV_PACKET_FTP};
    request.of.ftp = (ssv_ftp_t){.sequence = 60, .session = answer.of.ftp.session, .opcode = SSV_FTP_BURST, .size = 77};
    TEST_ASSERT_TRUE(exchange(SSV_PACKET_FTP));
    for (size_t at = 0, k = 0; at < file_length; k++) {
        TEST_ASSERT_EQUAL_UINT32(at, answer.of.ftp.offset);
        TEST_ASSERT_EQUAL_UINT16(61 + k, answer.of.ftp.sequence);
        TEST_ASSERT_EQUAL_MEMORY(file + at, answer.of.ftp.data, answer.of.ftp.size);
        at += answer.of.ftp.size;
        TEST_ASSERT_EQUAL_INT(at == file_length, answer.of.ftp.last_of_burst);
        TEST_ASSERT_TRUE(answer.of.ftp.size == 77 || at == file_length);
        bool got = at == file_length;
        for (size_t length; !got && (length = ssv_link_vehicle_poll(&vehicle, now_us, &state, frame)) > 0;) {
            for (size_t i = 0; i < length; i++) got = hear(&tool, now_us, frame[i]) && answer.kind == SSV_PACKET_FTP;
        }
        TEST_ASSERT_TRUE(got);
        now_us += 14 * S; // 14 s between frames of the burst: what goes out keeps the session alive
    }
    TEST_ASSERT_TRUE(vehicle.server.open);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_OK, ftp(69, answer.of.ftp.session, SSV_FTP_READ, 100, NULL, 10));
    TEST_ASSERT_EQUAL_UINT8(10, answer.of.ftp.size);
    TEST_ASSERT_EQUAL_MEMORY(file + 100, answer.of.ftp.data, 10);
    TEST_ASSERT_EQUAL_UINT8(SSV_FTP_END_OF_FILE,
                            ftp(70, answer.of.ftp.session, SSV_FTP_READ, (uint32_t)file_length, NULL, 10));
}

// ---- Commit ---------------------------------------------------------------------------------------------------------

static void test_a_commit_is_refused_with_its_reason_and_what_is_live_stays(void) {
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_PLAN_HASH, commit(timeline.plan_hash ^ 1));
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_PLAN_HASH, commit(timeline.plan_hash ^ UINT64_C(1) << 63));
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_NO_REASON, commit(timeline.plan_hash));
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_COMMITTED, event.kind);
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(SSV_LINK_NO_REASON, commit(timeline.plan_hash), "its answer was lost");
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_NOTHING, event.kind);
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_NOTHING, commit(timeline.plan_hash + 1));
    uint8_t live[SSV_TIMELINE_FILE_BYTES_MAX];
    memcpy(live, file, file_length);
    const size_t live_length = file_length;

    timeline.mass_configuration = 8;
    make_file();
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_MASS_CONFIGURATION, commit(timeline.plan_hash));
    timeline.mass_configuration = 7;
    timeline.u_max_N = 6.01F;
    make_file();
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_FORCE, commit(timeline.plan_hash));
    timeline.u_max_N = 6;
    make_file();
    upload();
    state.may_swap = false;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_BUSY, commit(timeline.plan_hash));
    state.may_swap = true;
    state.pose.p_IS_m[1] = 0.06F;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_START_POSE, commit(timeline.plan_hash));
    state.pose.p_IS_m[1] = 0.04F;
    state.pose.known = false;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_START_POSE, commit(timeline.plan_hash));
    state.pose.known = true;
    now_us += 601 * S;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_EXPIRY, commit(timeline.plan_hash));
    TEST_ASSERT_EQUAL_MEMORY(live, ssv_link_vehicle_live(&vehicle, NULL), live_length);
}

static void test_the_start_attitude_may_be_0_05_rad_off_about_any_axis_in_either_sign_of_the_quaternion(void) {
    for (int axis = 0; axis < 3; axis++) {
        for (int k = 0; k < 4; k++) {
            const bool inside = k % 2 == 0;
            const float half_rad = inside ? 0.0249F : 0.0252F, sign = k < 2 ? 1.0F : -1.0F;
            setUp();
            // Here half the sine's argument is its sine to 1e-5.
            state.pose.q_IS[0] = sign * (1 - half_rad * half_rad / 2);
            state.pose.q_IS[1 + axis] = sign * half_rad;
            upload();
            TEST_ASSERT_EQUAL_UINT8(inside ? SSV_LINK_NO_REASON : SSV_LINK_START_POSE, commit(timeline.plan_hash));
        }
    }
}

static void test_the_start_attitude_is_compared_by_the_angle_between_the_two_whatever_they_are(void) {
    for (int k = 0; k < 400; k++) {
        const bool inside = k % 2 == 0;
        double a[4], axis[4] = {0, 0, 0, 0}, square = 0, axis_square = 0;
        setUp();
        draw_seed(UINT64_C(500) + (uint64_t)k);
        for (int i = 0; i < 4; i++) {
            a[i] = draw_between(-1, 1);
            square += a[i] * a[i];
            if (i > 0) {
                axis[i] = draw_between(-1, 1);
                axis_square += axis[i] * axis[i];
            }
        }
        const double half_rad = inside ? 0.0249 : 0.0252, s = sin(half_rad) / sqrt(axis_square), c = cos(half_rad);
        for (int i = 0; i < 4; i++) {
            a[i] /= sqrt(square);
            timeline.q_IS[i] = (float)a[i];
        }
        const double b[4] = {c, s * axis[1], s * axis[2], s * axis[3]};
        state.pose.q_IS[0] = (float)(a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]);
        state.pose.q_IS[1] = (float)(a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]);
        state.pose.q_IS[2] = (float)(a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]);
        state.pose.q_IS[3] = (float)(a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]);
        make_file();
        upload();
        TEST_ASSERT_EQUAL_UINT8(inside ? SSV_LINK_NO_REASON : SSV_LINK_START_POSE, commit(timeline.plan_hash));
    }
}

static void test_an_older_timeline_does_not_follow_a_newer_one(void) {
    const ssv_timeline_stamp_t older = {EPOCH_US - 1, 600000};
    upload();
    commit(timeline.plan_hash);
    timeline.plan_hash += 2;
    file_length = ssv_timeline_encode(&timeline, &older, file, sizeof file);
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_EPOCH, commit(timeline.plan_hash));
}

static void test_a_new_upload_or_a_drop_forgets_what_was_incoming_and_never_what_is_live(void) {
    upload();
    commit(timeline.plan_hash);
    upload();
    path(90, SSV_FTP_CREATE, SSV_FTP_INCOMING_PATH);
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_LENGTH, commit(timeline.plan_hash));
    upload();
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_ACCEPTED, command(SSV_LINK_DROP, 0, 0));
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_NOTHING, commit(timeline.plan_hash + 2));
    TEST_ASSERT_EQUAL_MEMORY(file, ssv_link_vehicle_live(&vehicle, NULL), file_length);
}

// ---- Commands -------------------------------------------------------------------------------------------------------

static void test_the_vehicle_judges_its_commands_and_its_answer_goes_to_who_asked(void) {
    upload();
    commit(timeline.plan_hash);
    request = (ssv_packet_t){.kind = SSV_PACKET_COMMAND, .target_sysid = 1, .target_compid = 1};
    request.of.command.command = SSV_LINK_START;
    request.of.command.x = (uint32_t)timeline.plan_hash;
    request.of.command.y = (uint32_t)(timeline.plan_hash >> 32);
    deliver(frame, ssv_wire_send(&tool, now_us, &request, frame));
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_COMMANDED, event.kind);
    TEST_ASSERT_EQUAL_UINT64(timeline.plan_hash, event.of.command.plan_hash);
    TEST_ASSERT_EQUAL_UINT8(255, event.sysid);
    TEST_ASSERT_EQUAL_UINT8(190, event.compid);
    ssv_link_vehicle_answer(&vehicle, &event, SSV_LINK_DENIED, SSV_LINK_NOT_ARMED);
    const size_t length = ssv_link_vehicle_poll(&vehicle, now_us, &state, frame);
    bool got = false;
    for (size_t i = 0; i < length; i++) got = hear(&tool, now_us, frame[i]);
    TEST_ASSERT_TRUE(got && answer.kind == SSV_PACKET_ACK);
    TEST_ASSERT_EQUAL_UINT8(190, answer.target_compid);
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, answer.of.ack.result);
    TEST_ASSERT_EQUAL_INT32(SSV_LINK_NOT_ARMED, answer.of.ack.detail);
}

static void test_a_start_names_the_live_plan_and_comes_in_time_or_is_refused_by_the_link(void) {
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_START, timeline.plan_hash, 0));
    TEST_ASSERT_EQUAL_INT32(SSV_LINK_NOTHING, answer.of.ack.detail);
    upload();
    commit(timeline.plan_hash);
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_START, timeline.plan_hash + 1, 0));
    TEST_ASSERT_EQUAL_INT32(SSV_LINK_PLAN_HASH, answer.of.ack.detail);
    now_us += 601 * S;
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_START, timeline.plan_hash, 0));
    TEST_ASSERT_EQUAL_INT32(SSV_LINK_EXPIRY, answer.of.ack.detail);
    state.phase = SSV_LINK_EXECUTING; // then the start is one that comes again
    request.target_sysid = request.target_compid = 1;
    deliver(frame, ssv_wire_send(&tool, now_us, &request, frame));
    TEST_ASSERT_EQUAL_INT(SSV_LINK_VEHICLE_COMMANDED, event.kind);
}

static void test_values_that_mean_nothing_are_denied(void) {
    const float values[] = {2, -1, 0.5F, (float)(1e308 * 10)};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_ARM, 0, values[i]));
        TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_PAUSE_CONTINUE, 0, values[i]));
    }
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_DENIED, command(SSV_LINK_TERMINATE, 0, 0));
    TEST_ASSERT_EQUAL_UINT8(SSV_LINK_UNSUPPORTED, command(22, 0, 0));
}

static void test_a_command_of_the_planner_is_given_again_until_it_is_answered_or_given_up(void) {
    static world_t world;
    world_init(&world, 5760, 1000, 0);
    world.up.cut = true;
    TEST_ASSERT_TRUE(ssv_link_planner_command(&world.planner, 0, SSV_LINK_ARM, 1, 0));
    TEST_ASSERT_FALSE(ssv_link_planner_command(&world.planner, 0, SSV_LINK_DROP, 0, 0));
    ssv_link_planner_event_t got = world_await(&world, SSV_LINK_PLANNER_ANSWERED, 60 * S);
    TEST_ASSERT_EQUAL_INT(SSV_LINK_NO_ANSWER, got.of.answer.result);
    TEST_ASSERT_INT64_WITHIN(1 * S, 10 * S, world.now_us);
    world.up.cut = false;
    world.up.loss = world.down.loss = 0.3;
    for (int k = 0; k < 50; k++) {
        TEST_ASSERT_TRUE(ssv_link_planner_command(&world.planner, world.now_us, SSV_LINK_ARM, k % 2, 0));
        got = world_await(&world, SSV_LINK_PLANNER_ANSWERED, world.now_us + 60 * S);
        TEST_ASSERT_EQUAL_INT(SSV_LINK_ACCEPTED, got.of.answer.result);
        TEST_ASSERT_EQUAL_INT(k % 2 == 1 ? SSV_LINK_READY : SSV_LINK_DISARMED, world.state.phase);
    }
}

static void test_an_upload_that_arrived_otherwise_than_it_was_sent_is_made_anew(void) {
    static world_t world;
    world_init(&world, 5760, 1000, 0);
    ssv_link_planner_upload(&world.planner, file, file_length);
    int num_spoilt = 0;
    ssv_link_planner_event_t got = {.kind = SSV_LINK_PLANNER_NOTHING};
    while (got.kind != SSV_LINK_PLANNER_UPLOADED && world.now_us < 60 * S) {
        got = world_run(&world, world.now_us + 1000);
        if (num_spoilt == 0 && world.vehicle.length[1] == file_length) {
            world.vehicle.image[1][200] ^= 1;
            num_spoilt++;
        }
    }
    TEST_ASSERT_EQUAL_INT(1, num_spoilt);
    TEST_ASSERT_EQUAL_INT(SSV_LINK_PLANNER_UPLOADED, got.kind);
    TEST_ASSERT_EQUAL_MEMORY(file, world.vehicle.image[1], file_length);
}

static void test_only_what_has_the_length_of_a_timeline_file_is_uploaded(void) {
    static ssv_link_planner_t planner;
    const ssv_link_planner_config_t config = default_planner(3);
    ssv_link_planner_init(&planner, &config);
    TEST_ASSERT_FALSE(ssv_link_planner_upload(&planner, file, 0));
    TEST_ASSERT_FALSE(ssv_link_planner_upload(&planner, file, SSV_TIMELINE_HEADER_BYTES - 1));
    TEST_ASSERT_FALSE(ssv_link_planner_upload(&planner, file, SSV_TIMELINE_FILE_BYTES_MAX + 1));
    TEST_ASSERT_TRUE(ssv_link_planner_upload(&planner, file, file_length));
}

static void test_the_stop_takes_the_place_of_a_command_that_waits(void) {
    static world_t world;
    world_init(&world, 5760, 1000, 0);
    TEST_ASSERT_TRUE(ssv_link_planner_command(&world.planner, 0, SSV_LINK_ARM, 1, 0));
    TEST_ASSERT_TRUE(ssv_link_planner_command(&world.planner, 0, SSV_LINK_TERMINATE, 1, 0));
    world_await(&world, SSV_LINK_PLANNER_ANSWERED, 5 * S);
    TEST_ASSERT_EQUAL_INT(SSV_LINK_STOPPED, world.state.phase);
}

static void test_the_log_keeps_the_newest_lines_whole(void) {
    for (int k = 0; k < 1000; k++) {
        char text[60] = "line 0000 of a log that is longer than its buffer, cut";
        for (int i = 0, n = k; i < 4; i++, n /= 10) text[8 - i] = (char)('0' + n % 10);
        ssv_link_vehicle_say(&vehicle, k * 1000, SSV_LINK_NOTICE, text);
        TEST_ASSERT_TRUE(vehicle.log_length <= SSV_LINK_LOG_BYTES);
        TEST_ASSERT_EQUAL_CHAR('\n', vehicle.log[vehicle.log_length - 1]);
    }
    TEST_ASSERT_EQUAL_MEMORY("999 5 line 0999", vehicle.log + vehicle.log_length - 57, 15);
    TEST_ASSERT_TRUE(vehicle.log_length > SSV_LINK_LOG_BYTES - 60);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_flipped_bit_of_a_frame_is_counted_or_at_least_not_taken);
    RUN_TEST(test_bytes_that_look_like_a_start_hide_no_frame);
    RUN_TEST(test_losses_are_counted_per_peer_by_gaps_in_the_sequence_numbers);
    RUN_TEST(test_a_frame_that_comes_twice_or_a_peer_that_begins_anew_is_no_loss);
    RUN_TEST(test_more_peers_than_the_table_holds_are_heard_all_the_same);
    RUN_TEST(test_what_is_for_another_system_or_component_is_passed_over);
    RUN_TEST(test_a_pose_comes_back_as_it_was_through_ned_and_frd);
    RUN_TEST(test_trims_that_are_no_numbers_are_not_taken);
    RUN_TEST(test_only_what_is_signed_with_the_key_is_heard);
    RUN_TEST(test_a_new_sender_whose_clock_is_more_than_60_s_behind_is_refused);
    RUN_TEST(test_signatures_follow_the_clock_and_not_the_count_of_frames);
    RUN_TEST(test_more_signing_senders_than_the_table_holds_are_refused_and_counted);
    RUN_TEST(test_a_struct_that_was_moved_works_on);
    RUN_TEST(test_no_write_without_a_session_and_none_into_somebody_else_s);
    RUN_TEST(test_a_session_ends_after_30_s_in_which_neither_end_did_anything);
    RUN_TEST(test_a_client_that_does_not_wait_for_the_answer_to_create_is_served_by_the_number_it_proposed);
    RUN_TEST(test_a_repeated_create_gets_the_same_answer_and_drops_nothing);
    RUN_TEST(test_offsets_and_sizes_are_checked_before_use);
    RUN_TEST(test_names_have_their_own_rules);
    RUN_TEST(test_a_burst_reads_the_live_file_in_chunks_of_the_size_asked_for);
    RUN_TEST(test_a_commit_is_refused_with_its_reason_and_what_is_live_stays);
    RUN_TEST(test_the_start_attitude_may_be_0_05_rad_off_about_any_axis_in_either_sign_of_the_quaternion);
    RUN_TEST(test_the_start_attitude_is_compared_by_the_angle_between_the_two_whatever_they_are);
    RUN_TEST(test_an_older_timeline_does_not_follow_a_newer_one);
    RUN_TEST(test_a_new_upload_or_a_drop_forgets_what_was_incoming_and_never_what_is_live);
    RUN_TEST(test_the_vehicle_judges_its_commands_and_its_answer_goes_to_who_asked);
    RUN_TEST(test_a_start_names_the_live_plan_and_comes_in_time_or_is_refused_by_the_link);
    RUN_TEST(test_values_that_mean_nothing_are_denied);
    RUN_TEST(test_a_command_of_the_planner_is_given_again_until_it_is_answered_or_given_up);
    RUN_TEST(test_an_upload_that_arrived_otherwise_than_it_was_sent_is_made_anew);
    RUN_TEST(test_only_what_has_the_length_of_a_timeline_file_is_uploaded);
    RUN_TEST(test_the_stop_takes_the_place_of_a_command_that_waits);
    RUN_TEST(test_the_log_keeps_the_newest_lines_whole);
    return UNITY_END();
}
