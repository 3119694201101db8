"""The demo: its tables, and that it leaves nothing behind however it ends."""
import csv
import importlib.util
import json
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

BIN = Path(os.environ["SSV_BIN_DIR"])
SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
DEMO = SOURCE / "host" / "demo.py"
PAPER_TABLES = SOURCE / "tests" / "golden" / "paper_tables.csv"
# A port of our own, so that tests which run at the same time do not hear one another.
ENVIRONMENT = os.environ | {"LCM_DEFAULT_URL": f"udpm://239.255.76.67:{10000 + os.getpid() % 10000}?ttl=0"}


def load_demo():
    spec = importlib.util.spec_from_file_location("demo", DEMO)
    demo = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(demo)
    return demo


def children_of(pid):
    listing = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(child) for child in listing.read_text().split()] if listing.exists() else []


def is_running(pid):
    """Whether the process exists and is not a zombie, which an absent parent may leave for a while."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def wait_until(condition, what):
    deadline_s = time.monotonic() + 30
    while not condition():
        if time.monotonic() > deadline_s:
            raise AssertionError(f"still not so after 30 s: {what}")
        time.sleep(0.01)


def shown_by_readme():
    """The lines of the demo that README shows, but for the one that has the time it took."""
    readme = (SOURCE / "README.md").read_text()
    tables = readme.split("and before it with this:\n")[1].split("\n## ")[0]
    flight = readme.split("noise of 5 mm and 0.5 deg:\n")[1].split("\nCtrl-C")[0]
    lines = [line for line in (tables + flight).splitlines() if line.strip() and "times real time" not in line]
    assert len(lines) > 20
    return lines


class TablesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.demo = load_demo()
        with PAPER_TABLES.open() as file:
            cls.rows = list(csv.DictReader(file))

    def test_rows_marked_reproduced_are_within_their_tolerance(self):
        compared = 0
        for attachment in self.demo.ATTACHMENTS:
            text = self.demo.one_attachment(attachment)
            command = [BIN / "ssv", "plan", "-", "--method", "paper", "--weights", "1,0", "--format", "json"]
            done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=60)
            ours = self.demo.our_values(json.loads(done.stdout))
            for row in self.rows:
                key = (row["table"], row["row"])
                if row["attachment"] == attachment and row["status"] == "reproduced" and key in ours:
                    with self.subTest(f"Table {row['table']}, {row['row']}, attachment {attachment}"):
                        self.assertLessEqual(abs(ours[key] - float(row["paper_value"])), float(row["tolerance"]))
                    compared += 1
        self.assertEqual(compared, 3 * 12 - 1)  # twelve rows, with the paper's rounding slip in one place

    def test_every_number_has_a_status_and_a_tolerance_or_a_reason(self):
        for row in self.rows:
            with self.subTest(row):
                self.assertIn(row["status"], ("reproduced", "paper slip", "reported only"))
                float(row["paper_value"])
                if row["status"] == "reproduced":
                    self.assertGreaterEqual(float(row["tolerance"]), 0)
                else:
                    self.assertNotEqual(row["reason"], "")

    def test_the_demo_prints_tables_winners_gain_size_and_time(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        page = Path(folder.name) / "demo.html"
        done = subprocess.run([sys.executable, "-B", DEMO, BIN, page], capture_output=True, text=True, timeout=120,
                              env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout.splitlines()[-1], f"See it fly, in any browser: {page}")
        self.assertIn('"outcome":"docked"', page.read_text())
        for words in ("Table 5", "Table 6", "Table 7", "Why they differ",
                      "keeps clear by", "9 plans by the paper's method received over LCM", "thrust segments each, planned in",
                      "3 plans by method optimal, effort best, received over LCM", "flown s", "times real time",
                      ": hit, attempt"):
            self.assertIn(words, done.stdout)
        self.assertLessEqual(max(map(len, done.stdout.splitlines())), 120)
        printed = [line.split() for line in done.stdout.splitlines()]
        for line in shown_by_readme():
            self.assertTrue(line.split() in printed, f"README shows what the demo does not print: {line}")
        lines = [line for line in done.stdout.splitlines() if line.startswith("for ")]
        ours = [line.split("(")[2].split()[-1] for line in lines]
        self.assertEqual(ours, ["2", "1"], "time favours the middle, fuel the end far from the contact")
        gains = [line.rsplit(")", 1)[1].split() for line in done.stdout.splitlines()
                 if line.startswith(("time alone", "fuel alone", "both "))]
        self.assertEqual(len(gains), 3)
        for paper, optimal, saving, _, least in gains:
            self.assertTrue(0 < float(least) <= float(optimal) < float(paper))
            self.assertAlmostEqual(float(saving), 100 * (1 - float(optimal) / float(paper)), delta=0.01)
        for line in done.stdout.splitlines():
            for field in [word for word in line.split() if word.endswith("%") and word[0] in "+-"]:
                after = line.split(field, 1)[1].split()
                self.assertEqual(abs(float(field[:-1])) > 0.2, bool(after) and len(after[0]) == 1, line)


class EndingTest(unittest.TestCase):
    """A demo whose `ssv` hangs is ended in every way; the planner that it started must be gone too."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bin = Path(folder.name)
        (self.bin / "ssv-plannerd").symlink_to(BIN / "ssv-plannerd")

    def fake_ssv(self, script):
        path = self.bin / "ssv"
        path.write_text("#!/bin/sh\n" + script)
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    def start(self):
        """The demo, and the processes that it started: the planner first."""
        demo = subprocess.Popen([sys.executable, "-B", DEMO, self.bin, self.bin / "demo.html"], env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)
        self.addCleanup(demo.kill)
        wait_until(lambda: len(children_of(demo.pid)) == 2, "planner and ssv run")
        return demo, children_of(demo.pid)

    def test_signals_end_the_planner_and_the_asker_too(self):
        self.fake_ssv("exec sleep 1000\n")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL):
            with self.subTest(number.name):
                demo, children = self.start()
                self.assertEqual(Path(f"/proc/{children[0]}/comm").read_text().strip(), "ssv-plannerd")
                demo.send_signal(number)
                self.assertNotEqual(demo.wait(timeout=30), 0)
                wait_until(lambda: not any(is_running(child) for child in children), "the children are gone")

    def test_a_failure_is_told_with_the_planner_s_log_and_ends_with_1(self):
        self.fake_ssv("echo 'ssv: no luck' >&2; exit 4\n")
        done = subprocess.run([sys.executable, "-B", DEMO, self.bin, self.bin / "demo.html"], capture_output=True, text=True,
                              timeout=60, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 1)
        self.assertIn("ssv: no luck", done.stderr)
        self.assertIn("The log of ssv-plannerd", done.stderr)


if __name__ == "__main__":
    unittest.main()
