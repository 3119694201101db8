"""ssv log from the outside: a flight that lcm-logger recorded, and what a bus may carry beside it. The judge decodes the log with the
message types in Python."""
import csv
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from collections import Counter
from pathlib import Path

import lcm
import ssv as messages

BIN = Path(os.environ["SSV_BIN_DIR"])
SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
LOGGER = Path(sys.executable).with_name("lcm-logger")
OK, FAILED, REFUSED, USAGE = 0, 1, 2, 64
TABLES = {"task_t": "tasks", "scenario_batch_t": "batches", "plan_t": "plans", "quote_batch_t": "answers", "planner_status_t": "status",
          "execution_t": "execution", "control_t": "control", "vehicle_state_t": "vehicle_state",
          "schedule_t": "schedules"}
BY_HASH = {getattr(messages, name)._get_packed_fingerprint(): name for name in TABLES}
LISTS = {"scenarios", "obstacles", "legs", "arcs", "segments", "events", "quotes", "candidates", "front", "parts"}


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def cells(value, name=""):
    """What a message's table should have: {column: value}, lists that have a table of their own left out."""
    if hasattr(value, "__slots__"):
        found = {}
        for field in value.__slots__:
            if not (field in LISTS and isinstance(getattr(value, field), (list, tuple))):
                found |= cells(getattr(value, field), f"{name}.{field}" if name else field)
        return found
    if isinstance(value, (list, tuple)):
        if name.endswith("attach_heights_m"):
            return {}
        is_numbers = not hasattr(value[0], "__slots__")
        names = {3: "xyz", 4: "wxyz"}.get(len(value) if is_numbers else 0, [str(i + 1) for i in range(len(value))])
        return {column: cell for i, element in zip(names, value) for column, cell in cells(element, f"{name}.{i}").items()}
    return {name: value}


class Log(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def turn(self, log, code=OK, to="tables"):
        done = subprocess.run([BIN / "ssv", "log", log, "--to", self.folder / to], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def table(self, name):
        return rows_of(self.folder / f"tables/{name}.csv")

    def record(self, path):
        """A flight and a batch, recorded."""
        environment = os.environ | {"LCM_DEFAULT_URL": f"udpm://239.255.76.67:{20000 + (11 * os.getpid()) % 20000}?ttl=0"}
        recorder = subprocess.Popen([LOGGER, "--quiet", "--force", path], env=environment, stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL, start_new_session=True)
        planner = subprocess.Popen([BIN / "ssv-plannerd"], env=environment, stderr=subprocess.DEVNULL)
        try:
            time.sleep(1)
            subprocess.run([BIN / "ssv", "quote", *sorted((SOURCE / "host/scenarios").glob("*.yaml")), "--candidates", "--front", "--lcm"],
                           env=environment, check=True, capture_output=True, timeout=60)
            subprocess.run([BIN / "ssv", "fly", SOURCE / "host/scenarios/clear/port2_either.yaml", "--sim", "--rate", "100", f"--lcm={environment['LCM_DEFAULT_URL']}"],
                           env=environment, check=True, capture_output=True, timeout=120)
            subprocess.run([BIN / "ssv", "schedule", SOURCE / "host/structures/one_beam.yaml", "--lcm"], env=environment, check=True,
                           capture_output=True, timeout=60)
            time.sleep(0.5)
        finally:
            planner.terminate()
            planner.wait()
            os.killpg(recorder.pid, signal.SIGTERM)
            recorder.wait()

    @unittest.skipUnless(LOGGER.exists(), "no lcm-logger")
    def test_every_message_of_a_recorded_flight_is_in_its_table_and_the_tables_add_up(self):
        path = self.folder / "flight.lcmlog"
        self.record(path)
        done = self.turn(path)
        found, decoded = Counter(), []
        for event in lcm.EventLog(str(path)):
            name = BY_HASH.get(bytes(event.data[:8]))
            found[name] += 1
            decoded.append((event, name, getattr(messages, name).decode(event.data) if name else None))
        listed = self.table("messages")
        self.assertEqual(len(listed), len(decoded))
        self.assertEqual([row["type"] for row in listed], [name or "" for _, name, _ in decoded])
        self.assertEqual([int(row["received_us"]) for row in listed], [event.timestamp for event, _, _ in decoded])
        for name in ("plan_t", "execution_t", "vehicle_state_t", "planner_status_t", "task_t", "quote_batch_t", "schedule_t"):
            self.assertGreater(found[name], 0)
        for name, table in TABLES.items():
            rows, of_type = self.table(table), [(event, message) for event, other, message in decoded if other == name]
            self.assertEqual(len(rows), len(of_type), table)
            for row, (event, message) in list(zip(rows, of_type))[::max(1, len(rows) // 40)]:
                self.assertEqual((int(row["message"]), row["channel"]), (event.eventnum, event.channel))
                self.assert_cells(row, cells(message))
        plans = [(event, message) for event, name, message in decoded if name == "plan_t"]
        for table in ("legs", "arcs", "segments", "events"):
            wanted = [(event.eventnum, i, element) for event, plan in plans for i, element in enumerate(getattr(plan, table))]
            rows = self.table(table)
            self.assertEqual(len(rows), len(wanted))
            for row, (number, i, element) in zip(rows, wanted):
                self.assertEqual((int(row["message"]), int(row["index"])), (number, i))
                self.assert_cells(row, cells(element))
        parts = [(event.eventnum, i, part) for event, name, message in decoded if name == "schedule_t"
                 for i, part in enumerate(message.parts)]
        rows = self.table("parts")
        self.assertEqual([(int(row["message"]), int(row["index"])) for row in rows], [part[:2] for part in parts])
        for row, (_, _, part) in zip(rows, parts):
            self.assert_cells(row, cells(part))
        quotes = [quote for _, name, message in decoded if name == "quote_batch_t" for quote in message.quotes]
        self.assertEqual(len(self.table("quotes")), len(quotes))
        self.assertEqual(len(self.table("front")), sum(quote.num_front for quote in quotes))
        candidates = [(i, k) for _, name, message in decoded if name == "quote_batch_t" for i, quote in enumerate(message.quotes)
                      for k in range(quote.num_candidates)]
        self.assertEqual([(int(row["quote"]), int(row["index"])) for row in self.table("candidates")], candidates)
        # What the rows of a plan add up to is what it says of itself.
        for event, plan in plans:
            mine = [row for row in self.table("legs") if int(row["message"]) == event.eventnum]
            self.assertAlmostEqual(sum(float(row["duration_s"]) for row in mine), plan.quote.time_s, 9)
            self.assertAlmostEqual(sum(float(row["impulse_Ns"]) for row in mine), plan.quote.impulse_Ns, 6)
            lines = [row for row in self.table("segments") if int(row["message"]) == event.eventnum]
            self.assertAlmostEqual(sum(float(row["duration_s"]) for row in lines), plan.quote.time_s, 9)
        self.assertIn(f"{sum(found.values()) - found[None]} messages of ours", done.stdout)

    def assert_cells(self, row, wanted):
        for column, value in wanted.items():
            if isinstance(value, str):
                self.assertEqual(row[column], value, column)
            elif isinstance(value, float):
                self.assertEqual(float(row[column]), value, column)
            elif isinstance(value, bool):
                self.assertEqual(row[column], str(int(value)), column)
            elif column.endswith(("_hash", "_id", ".obstacles", ".left")) or column in ("obstacles", "left"):
                self.assertEqual(int(row[column], 16), value % 2**64, column)
            elif row[column].lstrip("-").isdigit():
                self.assertEqual(int(row[column]), value, column)
            else:
                self.assertRegex(row[column], r"\A[a-z_]+\Z", column)  # a word of an enum

    def write(self, *events):
        path = self.folder / "made.lcmlog"
        log = lcm.EventLog(str(path), "w", True)
        for i, (channel, data) in enumerate(events):
            log.write_event(1_000_000 + i, channel, data)
        log.close()
        return path

    def test_what_is_none_of_ours_broken_or_cut_off_is_accounted_for(self):
        status = messages.planner_status_t()
        status.planner.version = 'a "quoted", name\nwith \x1b[31m in it'
        sound = status.encode()
        state = messages.vehicle_state_t()
        state.time_s = math.nan
        path = self.write(("SSV_PLANNER_STATUS", sound), ("STRANGE", b"hello there"), ("SSV_PLAN", b""), ("SSV_PLANNER_STATUS", sound[:-3]),
                          ("SSV_PLANNER_STATUS", sound + b"x"), ("SSV_VEHICLE_STATE", state.encode()),
                          ("SSV_PLANNER_STATUS", struct.pack(">q", 1) + sound[8:]))
        data = path.read_bytes()
        path.write_bytes(data + data[:40])
        done = self.turn(path)
        self.assertIn("1 messages of ours, 6 others", done.stdout)
        self.assertIn("40 bytes at the end of the log are no whole message", done.stdout)
        self.assertEqual([row["outcome"] for row in self.table("messages")],
                         ["read", "not ours", "not ours", "broken", "broken", "broken", "not ours"])
        row, = self.table("status")
        self.assertEqual(row["planner.version"], 'a "quoted", name?with ?[31m in it')

    def test_tables_of_an_earlier_log_do_not_stay(self):
        plan = messages.plan_t()
        self.turn(self.write(("SSV_PLAN", plan.encode())))
        self.assertEqual(len(self.table("plans")), 1)
        self.turn(self.write(("STRANGE", b"nothing of ours")))
        self.assertEqual(len(self.table("plans")), 0)

    def test_what_is_refused(self):
        self.assertIn("no regular file", self.turn("/nowhere.lcmlog", REFUSED).stderr)
        self.assertIn("no regular file", self.turn(self.folder, REFUSED).stderr)
        wrong = self.folder / "wrong.lcmlog"
        wrong.write_bytes(b"this is no log, " * 1000)
        self.assertIn("no log of lcm-logger", self.turn(wrong, REFUSED).stderr)
        (self.folder / "file").write_text("")
        sound = self.write(("STRANGE", b"x"))
        self.assertIn("file", self.turn(sound, FAILED, to="file").stderr)
        for arguments, said in (([], "which log?"), ([sound], "--to which folder?"), ([sound, sound], "one log at a time")):
            done = subprocess.run([BIN / "ssv", "log", *arguments], capture_output=True, text=True)
            self.assertEqual(done.returncode, USAGE)
            self.assertIn(said, done.stderr)
        help_ = subprocess.run([BIN / "ssv", "log", "--help"], capture_output=True, text=True, check=True).stdout
        for word in ("Examples:", "Exit codes:", "messages.csv"):
            self.assertIn(word, help_)


if __name__ == "__main__":
    unittest.main(verbosity=2)
