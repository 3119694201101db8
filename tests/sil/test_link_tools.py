"""Wireshark and MAVProxy against the link: tshark names every field of our messages with its unit, MAVProxy sees the
vehicle and calls its mode by a name that is true. tshark is used where it is installed; SSV_LONG=1 demands it, and
MAVProxy, which the set-up fetches then."""
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

os.environ["MAVLINK20"] = "1"
MAVLINK_DIR = pathlib.Path(os.environ["SSV_MAVLINK_DIR"])
sys.path.insert(0, str(MAVLINK_DIR))
import ssv  # noqa: E402  made by mavgen from ssv.xml

SESSION, BENCH = os.environ["SSV_LINK_SESSION"], os.environ["SSV_LINK_BENCH"]
BUILD_DIR, LONG = pathlib.Path(os.environ["SSV_BUILD_DIR"]), os.environ.get("SSV_LONG")


def write_capture(path, frames):
    """A capture of link type USER0, for which the dissector registers itself; one frame is one packet."""
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", 0xa1b2c3d4, 2, 4, 0, 0, 65535, 147))
        for frame in frames:
            file.write(struct.pack("<IIII", 0, 0, len(frame), len(frame)) + frame)


class Wireshark(unittest.TestCase):
    def test_tshark_names_every_message_and_our_fields_with_their_units(self):
        if shutil.which("tshark") is None:
            self.assertFalse(LONG, "the long run needs tshark")
            self.skipTest("no tshark here")
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([SESSION, folder], check=True)
            messages = [message for way in ("up", "down")
                        for message in ssv.MAVLink(None).parse_buffer(pathlib.Path(folder, f"{way}.bin").read_bytes())]
            write_capture(f"{folder}/session.pcap", [bytes(message.get_msgbuf()) for message in messages])
            text = subprocess.run(["tshark", "-X", f"lua_script:{MAVLINK_DIR}/ssv.lua", "-r", f"{folder}/session.pcap", "-V"],
                                  check=True, capture_output=True, text=True).stdout
        for message in messages:
            self.assertIn(f"Message id: {message.get_type()} ({message.get_msgId()})", text)
        self.assertEqual(text.count("Message id: "), len(messages))
        for name in ("SSV_EXECUTION", "SSV_BEAT", "SSV_TRIM"):
            message = getattr(ssv, f"MAVLink_{name.lower()}_message")
            for field in message.fieldnames:
                unit = message.fieldunits_by_name[field]
                field = field + "[0]" if field == "trim" else field
                self.assertRegex(text, rf"(?m)^ +{field.replace('[', '.').replace(']', '.')} \(\w+\) \[{unit}\]")
        self.assertIn("trim[5] (float) [N]: -6", text)


@unittest.skipUnless(LONG, "MAVProxy is fetched for the long run alone")
class Mavproxy(unittest.TestCase):
    def test_it_sees_the_vehicle_its_parameters_and_a_mode_that_is_true(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        with tempfile.TemporaryDirectory() as folder:
            bench = subprocess.Popen([BENCH, "0", str(port)], stdout=subprocess.DEVNULL)
            proxy = subprocess.Popen(
                [BUILD_DIR / "mavproxy/bin/mavproxy.py", f"--master=udpin:127.0.0.1:{port}", f"--state-basedir={folder}",
                 "--default-modules=ftp,mode,param,arm"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, text=True)
            try:
                time.sleep(12)
                proxy.stdin.write("status\n")
                proxy.stdin.flush()
                time.sleep(3)  # an exit that comes at once is obeyed first
                seen, _ = proxy.communicate("exit\n", timeout=30)
            finally:
                for process in (proxy, bench):
                    process.kill()
                    process.wait()
        for line in ("Detected vehicle 1:1", "Mode MANUAL", "Received 3 parameters", "custom_mode : 19", "MAV Errors: 0"):
            self.assertIn(line, seen)


if __name__ == "__main__":
    unittest.main()
