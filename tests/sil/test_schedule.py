"""ssv schedule from the outside: tables, JSON, structures that are refused, and prices over LCM."""
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

BIN = Path(os.environ["SSV_BIN_DIR"])
STRUCTURES = Path(os.environ["SSV_SOURCE_DIR"]) / "host" / "structures"
EASE = (STRUCTURES / "ease.yaml").read_text()
# A port of our own, so that tests which run at the same time do not hear one another.
URL = f"udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0"

# Three slots of EASE, for what takes long with six.
THREE = EASE[:EASE.index("  - {name: leg_east,")]


def ssv_schedule(*arguments, text=None):
    return subprocess.run([BIN / "ssv", "schedule", *map(str, arguments)], input=text, capture_output=True, text=True,
                          timeout=120)


def edited(text, *changes):
    for old, new in changes:
        if old not in text:
            raise ValueError(f"'{old}' is not in the file")
        text = text.replace(old, new, 1)
    return text


def line_of(text, part):
    return text[:text.index(part)].count("\n") + 1


class RefusedTest(unittest.TestCase):
    def assert_refused(self, text, at, key, reason):
        """`at` is in the line that is at fault."""
        done = ssv_schedule("-", text=text)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, rf"^ssv: standard input:{line_of(text, at)}:\d+: {key}: ")
        self.assertIn(reason, done.stderr)

    def test_unknown_names(self):
        slot = "{name: base_east_north, join"
        self.assert_refused(edited(EASE, (slot, "{name: base_east_north, beam: b7, join")), "beam: b7",
                            r"slots\[0\]\.beam", "is no beam of this file")
        self.assert_refused(edited(EASE, ("hub: south, port: 2", "hub: sout, port: 2")), "hub: sout,",
                            r"slots\[1\]\.join\[1\]\.hub", "did you mean south?")
        self.assert_refused(edited(EASE, (slot, "{name: base_east_north, after: [leg], join")), "after: [leg]",
                            r"slots\[0\]\.after\[0\]", "is no slot of this file")
        self.assert_refused(edited(EASE, ("margin_m", "margn_m")), "margn_m", "margn_m", "did you mean margin_m?")

    def test_one_thing_twice(self):
        self.assert_refused(edited(EASE, ("{name: leg_north", "{name: leg_east")), "{name: leg_east, join: [{hub: north",
                            r"slots\[4\]\.name", "is used twice")
        self.assert_refused(edited(EASE, ("hub: north, port: 3", "hub: north, port: 1")), "{name: base_north_south",
                            r"slots\[1\]\.join\[0\]", "is used twice")
        self.assert_refused(
            edited(EASE, ("base_east_north,", "base_east_north, beam: b1,"), ("leg_south,", "leg_south, beam: b1,")),
            "{name: leg_south", r"slots\[5\]\.beam", "is used twice")

    def test_port_outside_its_hub(self):
        self.assert_refused(edited(EASE, ("hub: top, port: 3", "hub: top, port: 4")), "port: 4",
                            r"slots\[4\]\.join\[1\]\.port", "is no port of this hub, which has 1 to 3")

    def test_cyclic_precedence(self):
        text = edited(EASE, ("leg_east,", "leg_east, after: [leg_south],"), ("leg_south,", "leg_south, after: [leg_east],"))
        self.assert_refused(text, "{name: leg_east,", r"slots\[3\]\.after", "precedence is cyclic")

    def test_structure_that_does_not_close(self):
        done = ssv_schedule(STRUCTURES / "paper_hub.yaml")
        self.assertEqual(done.returncode, 2)
        self.assertIn("slots[0].join: does not close", done.stderr)

    def test_two_beams_in_one_place(self):
        self.assert_refused(edited(EASE, ("[-6, -1.2, 1]", "[-6, -2, 1]")), "{name: b2", r"beams\[1\]\.p_IB_m",
                            "two beams in one place")

    def test_too_few_beams(self):
        start, end = EASE.index("  - {name: b6"), EASE.index("\nslots:")
        self.assert_refused(EASE[:start] + EASE[end:], "{name: b1", "beams", "5 beams for 6 slots")


class ScheduleTest(unittest.TestCase):
    def schedule(self, *arguments, text=THREE):
        done = ssv_schedule("-", "--format", "json", *arguments, text=text)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_table(self):
        done = ssv_schedule(STRUCTURES / "one_beam.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        for part in ("Proved optimal", "the cheapest part each time", "assemble-structure\n  assemble-part beam span\n",
                     "fly-to-beam", "fly-beam-to-hub", " prices on "):
            self.assertIn(part, done.stdout)

    def test_sums_and_names(self):
        answer = self.schedule()
        schedule = answer["schedule"]
        parts = schedule["subtasks"]
        self.assertTrue(schedule["optimal"])
        self.assertEqual({part["slot"] for part in parts}, {"base_east_north", "base_north_south", "base_south_east"})
        self.assertEqual(len({part["beam"] for part in parts}), 3)
        for key in ("cost", "time_s", "impulse_Ns"):
            self.assertAlmostEqual(schedule[key], sum(part[key] for part in parts), delta=1e-9 * schedule[key])
        for part in parts:
            self.assertAlmostEqual(part["cost"], part["time_s"] + part["impulse_Ns"], delta=1e-9 * part["cost"])
            self.assertGreaterEqual(part["clearance_m"], 0.03 - 1e-6)  # the file's margin
        self.assertGreaterEqual(schedule["greedy_cost"], schedule["cost"] * (1 - 1e-12))

    def test_weights_are_those_of_the_option(self):
        schedule = self.schedule("--weights", "1,0")["schedule"]
        self.assertAlmostEqual(schedule["cost"], schedule["time_s"], delta=1e-9 * schedule["cost"])

    def test_precedence_is_kept(self):
        text = edited(THREE, ("base_east_north,", "base_east_north, after: [base_south_east],"))
        slots = [part["slot"] for part in self.schedule(text=text)["schedule"]["subtasks"]]
        self.assertLess(slots.index("base_south_east"), slots.index("base_east_north"))

    def test_output_goes_to_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "schedule.json"
            done = ssv_schedule("-", "--format", "json", "--output", path, text=THREE)
            self.assertEqual((done.returncode, done.stdout), (0, ""))
            self.assertTrue(json.loads(path.read_text())["schedule"]["optimal"])

    def test_wrong_arguments(self):
        for arguments in ([], ["a", "b"], ["a", "--weights", "1"], ["a", "--time-limit", "0"], ["a", "--format", "xml"]):
            self.assertEqual(ssv_schedule(*arguments).returncode, 64, arguments)


class OverLcmTest(unittest.TestCase):
    def test_planners_find_the_same_schedule(self):
        planners = [subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", URL], stderr=subprocess.DEVNULL)
                    for _ in range(2)]
        try:
            there = ssv_schedule("-", "--format", "json", "--lcm", URL, text=THREE)
        finally:
            for planner in planners:
                planner.terminate()
                planner.wait()
        here = ssv_schedule("-", "--format", "json", text=THREE)
        self.assertEqual(there.returncode, 0, there.stderr)
        self.assertEqual(json.loads(there.stdout)["schedule"], json.loads(here.stdout)["schedule"])

    def test_nobody_answers(self):
        done = ssv_schedule("-", "--lcm", URL, "--timeout", "1.5", text=THREE)
        self.assertEqual(done.returncode, 4)
        self.assertIn("1.5 s", done.stderr)


if __name__ == "__main__":
    unittest.main()
