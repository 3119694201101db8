"""ssv plot from the outside: the table adds up to the plan, the picture is the same twice, and it says what is missing."""
import csv
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SSV = Path(os.environ["SSV_BIN_DIR"]) / "ssv"
sys.path.insert(0, str(SOURCE / "lcmtypes"))
from sample_plan import sample  # noqa: E402

SCENARIO = SOURCE / "host/scenarios/clear/port2_either.yaml"
OK, FAILED, REFUSED, USAGE = 0, 1, 2, 64
DIGITS = 1e-5  # the table's numbers have six digits


@unittest.skipUnless(shutil.which("gnuplot"), "needs gnuplot (Debian package gnuplot-nox)")
class Plot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.text = subprocess.run([SSV, "plan", SCENARIO, "--format", "json"], capture_output=True, text=True, check=True).stdout
        self.plan = json.loads(self.text)["plan"]
        self.file = self.folder / "it's a plan.json"
        self.file.write_text(self.text)

    def plot(self, *arguments, code=OK, **options):
        done = subprocess.run([SSV, "plot", *arguments], capture_output=True, text=True, **options)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def rows(self, path):
        with path.open() as file:
            return list(csv.DictReader(file))

    def test_the_picture_is_the_same_twice_and_from_the_script_that_lies_beside_it(self):
        svg = self.folder / "it's.svg"
        self.plot(self.file, "--output", svg)
        first = svg.read_bytes()
        ElementTree.fromstring(first)
        for word in (b"T1 [N]", b"T6 [N]", b"speed [m/s]", b"rate [deg/s]", b"clear [m]", b"t [s]"):
            self.assertIn(word, first)
        self.plot(self.file, "--output", svg)
        self.assertEqual(svg.read_bytes(), first)
        svg.unlink()
        subprocess.run(["gnuplot", "it's.gp"], cwd=self.folder, check=True)
        self.assertEqual(svg.read_bytes(), first)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["it's a plan.json", "it's.csv", "it's.gp", "it's.svg"])

    def test_the_table_is_the_plan_s_motion_and_adds_up_to_its_time_and_impulse(self):
        self.plot(self.file, "--output", self.folder / "plan.svg")
        rows = self.rows(self.folder / "plan.csv")
        times = [float(row["t_s"]) for row in rows]
        self.assertEqual(times, sorted(times))
        self.assertEqual(times[0], 0)
        self.assertAlmostEqual(times[-1], self.plan["quote"]["time_s"], delta=1e-6 * times[-1])
        # Thrusts are straight lines between rows; on one that changes its sign the two triangles count.
        impulse_Ns = 0
        for a, b in zip(rows, rows[1:]):
            for k in range(1, 7):
                u, v, span_s = float(a[f"u{k}_N"]), float(b[f"u{k}_N"]), float(b["t_s"]) - float(a["t_s"])
                impulse_Ns += span_s * (abs(u + v) / 2 if u * v >= 0 else (u * u + v * v) / (abs(u) + abs(v)) / 2)
        self.assertAlmostEqual(impulse_Ns, self.plan["quote"]["impulse_Ns"], delta=2e-3 * impulse_Ns)  # of the lines themselves
        plan = json.loads(json.dumps(self.plan), object_hook=lambda fields: SimpleNamespace(**fields))
        joints = {round(leg["t_start_s"], 6) for leg in self.plan["legs"]}
        for row in random.Random(1).sample(rows, 60):
            t_s = float(row["t_s"])
            if round(t_s, 6) in joints or t_s >= self.plan["quote"]["time_s"]:
                continue
            p, _, v, _, _ = sample(plan, t_s)
            for axis, value in zip("xyz", p):
                self.assertAlmostEqual(float(row[f"p_IS_{axis}_m"]), value, delta=1e-6)
            self.assertAlmostEqual(float(row["speed_m_s"]), sum(x * x for x in v) ** 0.5, delta=DIGITS)
        least_m = min(float(row["clearance_m"]) for row in rows if row["clearance_m"])
        self.assertAlmostEqual(least_m, self.plan["clearance"]["seen_m"], delta=5e-3)  # the planner's own bracket
        self.assertEqual({row["phase"] for row in rows}, {"transit", "transfer"})

    def test_without_a_file_to_write_the_terminal_gets_it(self):
        done = self.plot(self.file)
        self.assertLessEqual(max(map(len, done.stdout.splitlines())), 100)
        for word in ("thrust [N]", "speed [m/s]", "clear [m]", "t [s]"):
            self.assertIn(word, done.stdout)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["it's a plan.json"])

    def test_an_assembly_is_plotted_on_one_axis_of_time(self):
        task = json.loads(self.text)
        both = self.folder / "both.json"
        both.write_text(json.dumps({"tasks": [task | {"name": 'first, "quoted"'}, task | {"name": "second"}]}))
        self.plot(both, "--output", self.folder / "both.svg")
        rows = self.rows(self.folder / "both.csv")
        self.assertEqual({row["task"] for row in rows}, {"first, 'quoted'", "second"})
        self.assertAlmostEqual(float(rows[-1]["t_s"]), 2 * self.plan["quote"]["time_s"], delta=1e-4)

    def test_without_gnuplot_table_and_script_are_there_and_what_to_install_is_said(self):
        done = self.plot(self.file, "--output", self.folder / "plan.svg", code=FAILED, env=os.environ | {"PATH": str(self.folder)})
        self.assertIn("apt-get install gnuplot-nox", done.stderr)
        self.assertTrue((self.folder / "plan.csv").exists() and (self.folder / "plan.gp").exists())
        self.assertFalse((self.folder / "plan.svg").exists())

    def test_what_is_refused(self):
        self.assertIn("ends in .svg", self.plot(self.file, "--output", "plan.png", code=USAGE).stderr)
        self.assertIn("which file?", self.plot(code=USAGE).stderr)
        self.assertIn("one file at a time", self.plot(self.file, self.file, code=USAGE).stderr)
        self.assertIn("plan: this key is missing", self.plot("-", input="{}", code=REFUSED).stderr)
        broken = json.loads(self.text)
        broken["plan"]["legs"][0]["num_arcs"] = 0
        done = self.plot("-", "--output", self.folder / "plan.svg", input=json.dumps(broken), code=REFUSED)
        self.assertIn("plan.legs[0]", done.stderr)
        self.assertFalse((self.folder / "plan.csv").exists())
        self.assertIn("/nowhere", self.plot(self.file, "--output", "/nowhere/plan.svg", code=FAILED).stderr)
        for word in ("Examples:", "Exit codes:", "gnuplot"):
            self.assertIn(word, self.plot("--help").stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
