"""Tools of others against the link: pymavlink decodes every frame of a session, its stock FTP client uploads a timeline
and starts it, and bad requests of others do no harm."""
import io
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

os.environ["MAVLINK20"] = "1"
sys.path.insert(0, os.environ["SSV_MAVLINK_DIR"])
import ssv  # noqa: E402  made by mavgen from ssv.xml
from pymavlink import mavftp, mavutil  # noqa: E402

mavutil.mavlink = ssv  # its connections speak our dialect
SESSION, BENCH = os.environ["SSV_LINK_SESSION"], os.environ["SSV_LINK_BENCH"]
OWN = {name: getattr(ssv, name) for name in ("MAVLINK_MSG_ID_SSV_EXECUTION", "MAVLINK_MSG_ID_SSV_BEAT", "MAVLINK_MSG_ID_SSV_TRIM")}


def frames_of(data):
    """The messages of a byte stream; BAD_DATA among them counts as such."""
    parser = ssv.MAVLink(None)
    parser.robust_parsing = True
    return parser.parse_buffer(data) or []


def timeline_file(plan_hash=0x123456789abcdef0, segments=3, epoch_us=1_767_225_600_000_000, mass=7):
    """The layout once more, from its description, not from the C code."""
    body = b"".join(struct.pack("<q12f", 1_000_000_000 + i, *([0.5 * (i % 12)] * 12)) for i in range(segments))
    total = sum(1_000_000_000 + i for i in range(segments))
    rest = struct.pack("<QqIIf3f4fHHHBBHBBIq", plan_hash, epoch_us, 600_000, mass, 6.0, 0, 0, 0, 1, 0, 0, 0, segments, 0,
                       1, 0, 0, segments, 1, 0, 0, total) + body
    return b"SSVT" + struct.pack("<HBBII", 1, 6, 2, 16 + len(rest), zlib.crc32(rest)) + rest


class Flight(unittest.TestCase):
    """pymavlink reads all that passes between executive and vehicle from the first heartbeat to the dock."""

    def test_pymavlink_decodes_every_frame_of_a_flight_and_finds_the_flight_in_them(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([os.environ["SSV_FLIGHT_FRAMES"], folder], check=True)
            data = {way: pathlib.Path(folder, f"{way}.bin").read_bytes() for way in ("up", "down")}
        frames = {way: frames_of(all_of_it) for way, all_of_it in data.items()}
        for way in data:
            names = {frame.get_type() for frame in frames[way]}
            self.assertFalse([name for name in names if name.startswith(("BAD_DATA", "UNKNOWN"))])
            self.assertEqual(sum(len(frame.get_msgbuf()) for frame in frames[way]), len(data[way]))
            self.assertEqual([frame.get_seq() for frame in frames[way]], [i % 256 for i in range(len(frames[way]))])
        told = [frame for frame in frames["down"] if frame.get_type() == "SSV_EXECUTION"]
        phases = [told[0].phase] + [b.phase for a, b in zip(told, told[1:]) if a.phase != b.phase]
        # Disarmed, executing, holding before the mate, executing, holding before the dock, done; what is short may be missed.
        self.assertRegex("".join(map(str, phases)), "^01?232326?$|^01?23236$")
        self.assertEqual((told[-1].events, told[-1].attempts), (2, 2))
        times = [frame.plan_time for frame in told]
        self.assertEqual(times, sorted(times))
        trims = [frame for frame in frames["up"] if frame.get_type() == "SSV_TRIM"]
        self.assertEqual([frame.sequence for frame in trims], list(range(1, len(trims) + 1)))
        self.assertTrue(all(0 <= frame.clock_rate <= 1 for frame in trims))
        print(f"{sum(map(len, frames.values()))} frames of a flight, {len(trims)} of them trims")


class Session(unittest.TestCase):
    """Both ends talk to one another, pymavlink listens."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([SESSION, folder], check=True)
            cls.bytes = {way: pathlib.Path(folder, f"{way}.bin").read_bytes() for way in ("up", "down")}
            cls.timeline = pathlib.Path(folder, "timeline").read_bytes()
        cls.frames = {way: frames_of(data) for way, data in cls.bytes.items()}

    def of(self, way, name):
        return [frame for frame in self.frames[way] if frame.get_type() == name]

    def test_pymavlink_decodes_every_frame_and_not_a_byte_is_left(self):
        for way, frames in self.frames.items():
            self.assertEqual(self.of(way, "BAD_DATA") + [f for f in frames if f.get_type().startswith("UNKNOWN")], [])
            self.assertEqual(sum(len(frame.get_msgbuf()) for frame in frames), len(self.bytes[way]))
            self.assertEqual([frame.get_seq() for frame in frames], [i % 256 for i in range(len(frames))])

    def test_each_end_says_what_it_is(self):
        vehicle, planner = self.of("down", "HEARTBEAT")[0], self.of("up", "HEARTBEAT")[0]
        self.assertEqual((vehicle.get_srcSystem(), vehicle.get_srcComponent(), vehicle.type, vehicle.autopilot),
                         (1, 1, ssv.MAV_TYPE_SUBMARINE, ssv.MAV_AUTOPILOT_GENERIC))
        self.assertEqual((planner.get_srcComponent(), planner.type, planner.autopilot),
                         (ssv.MAV_COMP_ID_PATHPLANNER, ssv.MAV_TYPE_ONBOARD_CONTROLLER, ssv.MAV_AUTOPILOT_INVALID))

    def test_the_mode_does_not_lie_to_tools_that_read_it_as_ardusub_s(self):
        names = {mavutil.mode_mapping_sub[heartbeat.custom_mode] for heartbeat in self.of("down", "HEARTBEAT")}
        self.assertEqual(names, {"MANUAL", "AUTO"})
        for heartbeat in self.of("down", "HEARTBEAT"):
            self.assertEqual(mavutil.mode_mapping_sub[heartbeat.custom_mode] == "AUTO", bool(heartbeat.base_mode & 4))

    def test_a_plan_hash_is_in_x_and_y_of_commit_and_start_bit_for_bit(self):
        plan_hash, = struct.unpack_from("<Q", self.timeline, 16)
        for command in (ssv.MAV_CMD_USER_1, ssv.MAV_CMD_USER_2):
            given = [frame for frame in self.of("up", "COMMAND_INT") if frame.command == command]
            self.assertEqual({(f.x & 0xffffffff) | (f.y & 0xffffffff) << 32 for f in given}, {plan_hash})
        self.assertEqual({f.live_hash for f in self.of("down", "SSV_EXECUTION")}, {0, plan_hash})

    def test_poses_are_turned_half_about_x_into_ned_and_frd(self):
        attitude, position = self.of("down", "ATTITUDE_QUATERNION")[0], self.of("down", "LOCAL_POSITION_NED")[0]
        for got, expected in (((position.x, position.y, position.z), (0.01, -0.02, -0.03)),
                              ((position.vx, position.vy, position.vz), (0.1, -0.2, -0.3)),
                              ((attitude.rollspeed, attitude.pitchspeed, attitude.yawspeed), (0.4, -0.5, -0.6))):
            for a, b in zip(got, expected):
                self.assertAlmostEqual(a, b, 6)

    def test_own_messages_carry_what_was_given(self):
        self.assertEqual([list(f.trim) for f in self.of("up", "SSV_TRIM")], [[1, -2, 3, -4, 5, -6]] * 30)
        self.assertEqual([f.sequence for f in self.of("up", "SSV_TRIM")], list(range(1, 31)))
        progress = [f.progress for f in self.of("up", "SSV_BEAT")]
        self.assertEqual(progress, sorted(progress))
        self.assertEqual(list(self.of("down", "ACTUATOR_OUTPUT_STATUS")[0].actuator[:7]), [1, 2, 3, 4, 5, 6, 0])

    def test_every_own_field_has_a_unit_and_ids_are_within_the_block(self):
        for name, number in OWN.items():
            self.assertTrue(53000 <= number <= 53099, name)
            message = ssv.mavlink_map[number]
            self.assertEqual(set(message.fieldunits_by_name), set(message.fieldnames), name)

    def test_the_timeline_file_is_laid_out_as_described(self):
        magic, version, thrusters, events, length, crc = struct.unpack_from("<4sHBBII", self.timeline)
        self.assertEqual((magic, version, thrusters, events, length), (b"SSVT", 1, 6, 2, len(self.timeline)))
        self.assertEqual(crc, zlib.crc32(self.timeline[16:]))
        durations = [struct.unpack_from("<q", self.timeline, 96 + 56 * i)[0] for i in range(128)]
        self.assertEqual(sum(durations), struct.unpack_from("<q", self.timeline, 88)[0])


class Bench(unittest.TestCase):
    """The vehicle's end on a socket."""

    key = None

    def setUp(self):
        environment = os.environ | ({"SSV_LINK_KEY": self.key} if self.key else {})
        self.process = subprocess.Popen([BENCH, "0"], stdout=subprocess.PIPE, text=True, env=environment)
        self.port = int(self.process.stdout.readline())
        self.link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{self.port}", source_system=255, source_component=190)
        if self.key:
            self.link.setup_signing(32 * self.key.encode(), sign_outgoing=True)
        self.link.mav.heartbeat_send(ssv.MAV_TYPE_GCS, ssv.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        self.assertIsNotNone(self.link.wait_heartbeat(timeout=5))

    def tearDown(self):
        self.link.close()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def command(self, command, plan_hash=0, param1=0):
        """The acknowledgement of a COMMAND_INT."""
        signed = [part - (1 << 32) if part >= 1 << 31 else part for part in (plan_hash & 0xffffffff, plan_hash >> 32)]
        self.link.mav.command_int_send(1, 1, 0, command, 0, 0, param1, 0, 0, 0, *signed, 0)
        ack = self.link.recv_match(type="COMMAND_ACK", blocking=True, timeout=5)
        self.assertEqual(ack.command, command)
        return ack.result, ack.result_param2 & 0xff

    def put(self, data, name="/plan/incoming"):
        client = mavftp.MAVFTP(self.link, 1, 1)
        client.ftp_settings.write_size = 239
        self.assertEqual(client.cmd_put(["memory", name], fh=io.BytesIO(data)).error_code, 0)
        return client, client.process_ftp_reply("Put", timeout=60).error_code

    def test_the_stock_ftp_client_uploads_a_timeline_that_is_committed_and_started_and_read_back(self):
        data, plan_hash = timeline_file(segments=128), 0x123456789abcdef0
        client, error = self.put(data)
        self.assertEqual(error, 0)
        self.assertEqual(self.command(ssv.MAV_CMD_USER_2, plan_hash)[0], ssv.MAV_RESULT_DENIED)
        self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash + 1), (ssv.MAV_RESULT_DENIED, ssv.SSV_REASON_PLAN_HASH))
        self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash), (ssv.MAV_RESULT_ACCEPTED, 0))
        self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash), (ssv.MAV_RESULT_ACCEPTED, 0), "once more")
        self.assertEqual(self.command(ssv.MAV_CMD_USER_2, plan_hash), (ssv.MAV_RESULT_DENIED, ssv.SSV_REASON_NOT_ARMED))
        self.assertEqual(self.command(ssv.MAV_CMD_COMPONENT_ARM_DISARM, param1=1), (ssv.MAV_RESULT_ACCEPTED, 0))
        self.assertEqual(self.command(ssv.MAV_CMD_USER_2, plan_hash), (ssv.MAV_RESULT_ACCEPTED, 0))
        while (heartbeat := self.link.recv_match(type="HEARTBEAT", blocking=True, timeout=5)).custom_mode != 3:
            self.assertIsNotNone(heartbeat)
        self.assertEqual(self.link.recv_match(type="SSV_EXECUTION", blocking=True, timeout=5).live_hash, plan_hash)
        for burst in (80, 239):  # sizes asked for are honoured
            client.ftp_settings.burst_read_size = burst
            self.assertEqual(client.read("/plan/live", len(data)), data)
        self.assertEqual(client.read("/plan/header", 96), data[:96])
        self.assertIn(b"timeline committed\n", client.read("/log/events", 1024))

    def test_a_torn_upload_is_not_committed_and_what_is_live_stays(self):
        good, plan_hash = timeline_file(segments=20), 0x123456789abcdef0
        client, error = self.put(good)
        self.assertEqual(error, 0)
        self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash), (ssv.MAV_RESULT_ACCEPTED, 0))
        for torn, reason in ((good[:-1], ssv.SSV_REASON_LENGTH), (good[:90], ssv.SSV_REASON_LENGTH),
                             (good[:500] + b"x" + good[501:], ssv.SSV_REASON_CRC), (b"", ssv.SSV_REASON_LENGTH),
                             (timeline_file(mass=8), ssv.SSV_REASON_MASS_CONFIGURATION),
                             (timeline_file(epoch_us=1), ssv.SSV_REASON_EPOCH),
                             (timeline_file(segments=0)[:95] + b"\1", ssv.SSV_REASON_CRC)):
            self.put(torn)
            self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash), (ssv.MAV_RESULT_DENIED, reason))
        self.assertEqual(client.read("/plan/live", len(good)), good)

    def test_a_stock_client_that_dies_after_any_answer_harms_nothing_and_the_next_one_completes(self):
        live, plan_hash = None, 1
        for answers in (0, 1, 2, 6, 29):
            dying = mavftp.MAVFTP(self.link, 1, 1)
            dying.ftp_settings.write_size = 239
            dying.cmd_put(["memory", "/plan/incoming"], fh=io.BytesIO(timeline_file(segments=128)))
            for _ in range(answers):
                answer = self.link.recv_match(type="FILE_TRANSFER_PROTOCOL", blocking=True, timeout=5)
                dying._MAVFTP__mavlink_packet(answer)
            data = timeline_file(plan_hash=plan_hash + 1, segments=30 + answers)
            client, error = self.put(data)
            self.assertEqual(error, 0)
            if live:
                self.assertEqual(client.read("/plan/live", len(live)), live)
            plan_hash += 1
            self.assertEqual(self.command(ssv.MAV_CMD_USER_1, plan_hash), (ssv.MAV_RESULT_ACCEPTED, 0))
            live = data

    def test_other_names_are_refused(self):
        for name in ("/etc/passwd", "/plan/live", "/plan/incoming/..", "x" * 200):
            self.assertNotEqual(self.put(b"x", name)[1], 0)

    def test_a_tool_gets_parameters_and_version_and_cannot_set_a_parameter(self):
        self.link.mav.param_request_list_send(1, 1)
        got = {}
        while len(got) < 3:
            value = self.link.recv_match(type="PARAM_VALUE", blocking=True, timeout=5)
            got[value.param_id] = value.param_value
        self.assertEqual(got, {"SSV_BEAT_WARN_S": 0.5, "SSV_BEAT_STOP_S": 1, "SSV_FORCE_N": 6})
        self.link.mav.param_set_send(1, 1, b"SSV_FORCE_N", 100, ssv.MAV_PARAM_TYPE_REAL32)
        self.assertEqual(self.link.recv_match(type="PARAM_VALUE", blocking=True, timeout=5).param_value, 6)
        self.link.mav.command_long_send(1, 1, ssv.MAV_CMD_REQUEST_MESSAGE, 0, 148, 0, 0, 0, 0, 0, 0)
        version = self.link.recv_match(type="AUTOPILOT_VERSION", blocking=True, timeout=5)
        self.assertTrue(version.capabilities & ssv.MAV_PROTOCOL_CAPABILITY_FTP)
        self.link.mav.timesync_send(0, 123)
        sync = self.link.recv_match(type="TIMESYNC", blocking=True, timeout=5)
        self.assertEqual(sync.ts1, 123)
        self.assertGreater(sync.tc1, 0)

    def test_a_hash_does_not_fit_into_command_long(self):
        self.link.mav.command_long_send(1, 1, ssv.MAV_CMD_USER_1, 0, 0, 0, 0, 0, 0, 0, 0)
        ack = self.link.recv_match(type="COMMAND_ACK", blocking=True, timeout=5)
        self.assertEqual(ack.result, ssv.MAV_RESULT_COMMAND_INT_ONLY)

    def test_a_message_interval_is_changed_on_request(self):
        self.assertEqual(self.interval(ssv.MAVLINK_MSG_ID_SSV_EXECUTION, 50_000), ssv.MAV_RESULT_ACCEPTED)
        start, count = time.monotonic(), 0
        while time.monotonic() - start < 1:
            count += self.link.recv_match(type="SSV_EXECUTION", blocking=True, timeout=0.2) is not None
        self.assertTrue(10 <= count <= 22, count)  # 20 on an idle machine
        self.assertEqual(self.interval(ssv.MAVLINK_MSG_ID_HEARTBEAT, -1), ssv.MAV_RESULT_DENIED)
        self.assertEqual(self.interval(9999, 50_000), ssv.MAV_RESULT_UNSUPPORTED)

    def interval(self, message, us):
        self.link.mav.command_long_send(1, 1, ssv.MAV_CMD_SET_MESSAGE_INTERVAL, 0, message, us, 0, 0, 0, 0, 0)
        return self.link.recv_match(type="COMMAND_ACK", blocking=True, timeout=5).result


class SignedBench(Bench):
    """All of the above with signatures; and what is unsigned, or signed with another key, is not heard."""

    key = "k"

    def test_only_the_key_opens_the_link(self):
        before = self.link.recv_match(type="SYS_STATUS", blocking=True, timeout=5).errors_count3
        for key in (None, b"x" * 32):
            stranger = mavutil.mavlink_connection(f"udpout:127.0.0.1:{self.port}", source_system=254, source_component=190)
            if key:
                stranger.setup_signing(key, sign_outgoing=True)
            stranger.mav.command_long_send(1, 1, ssv.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, 0, 0, 0, 0, 0, 0)
            stranger.close()
        time.sleep(0.2)
        self.assertEqual(self.command(ssv.MAV_CMD_REQUEST_MESSAGE, param1=ssv.MAVLINK_MSG_ID_SYS_STATUS)[0], 0)
        while (status := self.link.recv_match(type="SYS_STATUS", blocking=True, timeout=5)).errors_count3 < before + 2:
            self.assertIsNotNone(status)
        while (heartbeat := self.link.recv_match(type="HEARTBEAT", blocking=True, timeout=5)) is None:
            pass
        self.assertFalse(heartbeat.base_mode & ssv.MAV_MODE_FLAG_SAFETY_ARMED)


if __name__ == "__main__":
    unittest.main()
