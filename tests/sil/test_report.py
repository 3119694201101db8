"""The page of `ssv report`, as somebody sees it who opens it from the disk: a headless Chromium without a network opens it, moves
it and reads it back. Poses and thrusts are judged by the planner's own sampler, clearances by what the plan says."""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SSV = Path(os.environ["SSV_BIN_DIR"]) / "ssv"
SAMPLES = os.environ["SSV_PLAN_SAMPLES"]
PICTURES = Path(os.environ["SSV_PICTURES_DIR"])
sys.path.insert(0, str(SOURCE / "tests/support"))
sys.path.insert(0, str(SOURCE / "lcmtypes"))
from assembly import scheduled_tasks  # noqa: E402
from browser import CHROMIUM, Browser  # noqa: E402
from sample_plan import sample  # noqa: E402

SCENARIOS = sorted((SOURCE / "host/scenarios").glob("**/*.yaml"))
OK, FAILED, REFUSED, USAGE = 0, 1, 2, 64
PAGE_BYTES_MAX, ASSEMBLY_BYTES_MAX = 1.5e6, 5e6
POSE_M, POSE_RAD, THRUST_N = 1e-3, 2e-3, 1e-5  # what lies between two rows may be 0.3 mm and 1 mrad off; thrusts have 7 digits
DOCK_OFF_M = 0.04  # as far as a dock in rough water may be off
BRACKET_M = 5e-3  # of the planner's clearance
BEAM = 64


def between(rows, t_s):
    """The row at a time, number by number on the straight line between two."""
    i = next((i for i, row in enumerate(rows) if row[0] > t_s), len(rows) - 1)
    before, after = rows[i - 1], rows[i]
    part = (t_s - before[0]) / (after[0] - before[0])
    return [a + part * (b - a) for a, b in zip(before, after)]


def plant_ball(answer, gap_m):
    """A ball of 0.2 m that was seen later, so far from the vehicle halfway through the longest leg to the beam. @return its number"""
    leg = max((leg for leg in answer["plan"]["legs"] if leg["phase"] == "transit" and leg["kind"] == "translate"), key=lambda leg: leg["length"])
    middle = [(a + b) / 2 for a, b in zip(leg["X_IS_start"]["p_m"], leg["X_IS_end"]["p_m"])]
    along = [b - a for a, b in zip(leg["X_IS_start"]["p_m"], leg["X_IS_end"]["p_m"])]
    across = [along[1], -along[0], 0] if abs(along[2]) < 0.9 * math.hypot(*along) else [1, 0, -along[0] / along[2]]
    away_m = answer["scenario"]["vehicle"]["radius_m"] + 0.2 + gap_m
    scene, number = answer["scene"], answer["scene"]["num_obstacles"]
    scene["obstacles"].append({"kind": "capsule", "p_I_m": [m + away_m * a / math.hypot(*across) for m, a in zip(middle, across)],
                               "axis_I": [0, 0, 1], "length_m": 0, "radius_m": 0.2})
    scene["num_obstacles"] += 1
    answer["scenario"]["obstacles"] = f"{int(answer['scenario']['obstacles'], 16) | 1 << number:016x}"
    return number


def apart_rad(a, b):
    return 2 * math.acos(min(1, abs(sum(x * y for x, y in zip(a, b)))))


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def planned(self, scenario, *options):
        done = subprocess.run([SSV, "plan", scenario, "--format", "json", *options], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    def report(self, answer, name="plan", code=OK):
        """The page of an answer, by its path; or what is said about one that is refused."""
        file, page = self.folder / f"{name}.json", self.folder / f"{name}.html"
        page.unlink(missing_ok=True)
        file.write_text(answer if isinstance(answer, str) else json.dumps(answer))
        done = subprocess.run([SSV, "report", file, "--output", page], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(page.exists(), code == OK)
        return page if code == OK else done.stderr

    def data(self, page):
        return json.loads(re.search(r'<script type="application/json" id="data">(.*)</script>', page.read_text())[1])


@unittest.skipUnless(CHROMIUM, "needs Chromium (Debian package chromium)")
class InBrowser(InFolder):
    @classmethod
    def setUpClass(cls):
        cls.browser = cls.enterClassContext(Browser()) if hasattr(cls, "enterClassContext") else Browser().__enter__()
        if not hasattr(cls, "enterClassContext"):
            cls.addClassCleanup(cls.browser.__exit__)
        cls.browser.page("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
        PICTURES.mkdir(exist_ok=True)

    def open(self, page):
        self.browser.open(page.as_uri())
        self.browser.wait("window.ssv !== undefined")
        return self.browser.evaluate("ssv.state()")

    def state(self):
        return self.browser.evaluate("ssv.state()")

    def slide(self, t_s):
        self.browser.evaluate(f"(() => {{ const slider = document.getElementById('slider'); slider.value = {t_s!r};"
                              "slider.dispatchEvent(new Event('input')); })()")
        return self.state()

    def assert_quiet(self, page):
        self.assertEqual(self.browser.complaints(), [])
        self.assertEqual(self.browser.requests(), [page.as_uri()])

    def red_pixels(self):
        return self.browser.evaluate("(() => { const gl = document.getElementById('canvas').getContext('webgl2') || document.getElementById('canvas').getContext('webgl');"
                                     "const p = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);"
                                     "gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, p);"
                                     "let n = 0; for (let i = 0; i < p.length; i += 4) n += p[i] > 150 && p[i + 1] < 60 && p[i + 2] < 60; return n; })()")

    def samples(self, answer, count):
        """The core's samples of a plan, lists of numbers."""
        done = subprocess.run([SAMPLES, str(count)], input=json.dumps({"plan": answer["plan"]}), capture_output=True, check=True, text=True)
        return [list(map(float, line.split())) for line in done.stdout.splitlines()]

    def assert_shows(self, answer, state, sample, start_s=0):
        t_s, *numbers = sample
        self.assertLess(math.dist(state["X_IS"][:3], numbers[:3]), POSE_M)
        self.assertLess(apart_rad(state["X_IS"][3:], numbers[3:7]), POSE_RAD)
        for shown, sampled in zip(state["u_N"], numbers[13:], strict=True):
            self.assertAlmostEqual(shown, sampled, delta=THRUST_N)
        force_max_N, radius_m = (answer["scenario"]["vehicle"][key] for key in ("force_max_N", "radius_m"))
        for arrow_m, u_N in zip(state["arrows_m"], numbers[13:], strict=True):
            self.assertAlmostEqual(arrow_m, 2 * radius_m * abs(u_N) / force_max_N, delta=2e-3 * radius_m)
        for plot_s in state["plot_times_s"]:  # a hundredth of a pixel is how the line is placed
            self.assertAlmostEqual(plot_s, start_s + t_s, delta=0.02 * state["duration_s"] / 400)


class Page(InBrowser):
    def test_every_shipped_plan_is_drawn_at_any_time_as_the_sampler_has_it_without_a_word_or_a_request(self):
        for scenario in SCENARIOS:
            with self.subTest(scenario.stem):
                answer = self.planned(scenario)
                page = self.report(answer, scenario.stem)
                self.assertLessEqual(page.stat().st_size, PAGE_BYTES_MAX)
                state = self.open(page)
                self.assertTrue(state["has_scene"])
                self.assertLessEqual(max(state["in_view"]), 1, "start, path and goal are in the picture")
                for sample in self.samples(answer, 3):
                    self.assert_shows(answer, self.slide(sample[0]), sample)
                end = self.slide(state["duration_s"])
                final = answer["plan"]["quote"]["X_IB_final"]
                self.assertTrue(end["mated"] and end["docked"])
                self.assertLess(math.dist(end["X_IB"][0][:3], final["p_m"]), POSE_M)
                self.assert_quiet(page)
                print(f"{scenario.stem}: {page.stat().st_size / 1e6:.2f} MB", flush=True)

    def test_rows_are_as_close_as_they_are_said_to_be(self):
        rows = self.data(self.report(self.planned(SCENARIOS[0])))["tasks"][0]["rows"]
        for before, after in zip(rows, rows[1:]):
            self.assertLessEqual(math.dist(before[1][:3], after[1][:3]), 0.02 + 1e-6)
            self.assertLessEqual(apart_rad(before[1][3:], after[1][3:]), math.radians(2) + 1e-3)  # 7 digits of a cosine

    def test_the_least_clearance_that_is_shown_is_the_plan_s_own(self):
        for scenario in (path for path in SCENARIOS if path.parent.name == "clear"):
            with self.subTest(scenario.stem):
                answer = self.planned(scenario)
                clearance = answer["plan"]["clearance"]
                task = self.data(self.report(answer, scenario.stem))["tasks"][0]
                shown = min(row[6][0] for row in task["rows"] if row[6])
                self.assertAlmostEqual(shown, clearance["seen_m"], delta=BRACKET_M)
                self.assertEqual(task["clearance"]["obstacle"], clearance["obstacle"])
                self.assertAlmostEqual(task["clearance"]["certified_m"], clearance["certified_m"], delta=1e-6)
                self.open(self.folder / f"{scenario.stem}.html")
                self.browser.press("c")
                state = self.state()
                self.assertAlmostEqual(state["near"][0], clearance["seen_m"], delta=BRACKET_M)
                self.assertAlmostEqual(math.dist(state["near"][3:6], state["near"][6:9]), abs(state["near"][0]), delta=1e-5)
                self.assertFalse(state["closest_is_red"])

    def test_keys_move_everything(self):
        duration_s = self.open(self.report(self.planned(SCENARIOS[0])))["duration_s"]
        press, state = self.browser.press, self.state
        for key, shift, wanted_s in (("ArrowRight", False, 1), ("ArrowRight", True, 11), ("ArrowLeft", False, 10), ("ArrowLeft", True, 0),
                                     ("End", False, duration_s), ("Home", False, 0)):
            press(key, shift)
            self.assertAlmostEqual(state()["time_s"], wanted_s)
        press("n")
        self.assertEqual(state()["leg"], 1)
        press("p")
        self.assertEqual((state()["leg"], state()["time_s"]), (0, 0))
        speed = state()["speed"]
        press("]")
        self.assertGreater(state()["speed"], speed)
        press("Space")
        self.browser.wait("ssv.state().time_s > 3")
        press("Space")
        stopped = state()
        self.assertFalse(stopped["plays"])
        self.assertEqual(self.browser.evaluate("new Promise(done => setTimeout(() => done(ssv.state().time_s), 300))"), stopped["time_s"])
        cameras = set()
        for key in "1230":
            press(key)
            cameras.add(tuple(state()["camera_m"]))
            self.assertLessEqual(max(state()["in_view"]), 1)
        self.browser.evaluate("document.getElementById('canvas').focus()")
        for key in ("ArrowLeft", "ArrowUp", "+"):
            press(key)
            cameras.add(tuple(state()["camera_m"]))
        self.assertEqual(len(cameras), 7)
        self.assertEqual(state()["time_s"], stopped["time_s"])
        self.assertEqual(self.browser.complaints(), [])

    def test_play_ends_at_the_end(self):
        duration_s = self.open(self.report(self.planned(SCENARIOS[0])))["duration_s"]
        self.slide(duration_s - 1)
        self.browser.press("Space")
        self.browser.wait("!ssv.state().plays")
        self.assertEqual(self.state()["time_s"], duration_s)

    def test_what_comes_closer_than_the_margin_is_red(self):
        answer = self.planned(SOURCE / "host/scenarios/clear/on_axis.yaml")
        self.open(self.report(answer, "sound"))
        self.assertFalse(self.state()["closest_is_red"])
        self.assertTrue(self.browser.evaluate("document.getElementById('warning').hidden"))
        number = plant_ball(answer, 0.01)
        page = self.report(answer, "planted")
        self.open(page)
        self.browser.press("c")
        state = self.state()
        self.assertTrue(state["closest_is_red"])
        self.assertEqual(state["near"][1:3], [0, number])
        self.assertAlmostEqual(state["near"][0], 0.01, delta=1e-4)
        warning = self.browser.evaluate("document.getElementById('warning').textContent")
        self.assertIn("closer than the margin of 30 mm", warning)
        self.assertIn(f"obstacle {number}", warning)
        self.assertIn("no answer to its question", warning)
        self.assertEqual(self.browser.evaluate("document.getElementById('now').className"), "below")
        self.assertGreater(self.red_pixels(), 10)
        self.browser.screenshot(PICTURES / "planted.png")
        self.assert_quiet(page)

    def test_a_plan_through_its_own_beam_is_seen_to_be_one(self):
        self.open(self.report(self.planned(SOURCE / "host/scenarios/paper_case.yaml"), "paper_case"))
        self.browser.press("c")
        self.assertLess(self.state()["near"][0], -0.1)
        self.assertEqual(self.state()["near"][2], BEAM)
        self.assertTrue(self.state()["closest_is_red"])

    def test_zooming_one_plot_zooms_all_and_a_double_click_shows_all_of_it_again(self):
        duration_s = self.open(self.report(self.planned(SCENARIOS[0])))["duration_s"]
        box = self.browser.evaluate("(() => { const box = document.querySelector('.graph').getBoundingClientRect();"
                                    "return [box.left, box.top, box.width, box.height]; })()")
        x, y = box[0] + box[2] / 2, box[1] + box[3] / 3

        def mouse(kind, at, count=1):
            self.browser.page("Input.dispatchMouseEvent", type=kind, x=at, y=y, button="left", buttons=1, clickCount=count)

        mouse("mousePressed", x), mouse("mouseMoved", x + 40), mouse("mouseMoved", x + 80), mouse("mouseReleased", x + 80)
        ranges = self.browser.evaluate("ssv.state().plot_range_s")
        self.assertLess(ranges[1] - ranges[0], duration_s / 3)
        self.assertGreater(ranges[0], duration_s / 4)
        mouse("mousePressed", x), mouse("mouseReleased", x), mouse("mousePressed", x, 2), mouse("mouseReleased", x, 2)
        self.browser.wait(f"ssv.state().plot_range_s[1] > {0.99 * duration_s}")
        self.assertEqual(self.browser.complaints(), [])

    def test_nothing_in_a_file_becomes_part_of_the_page(self):
        answer = self.planned(SCENARIOS[0])
        evil = "</script><img src=http://example.net/x onerror=\"document.title='taken'\"><!--"
        answer = {"tasks": [answer | {"name": evil}, answer | {"name": evil}]}
        page = self.report(answer, "evil <b>&amp;")
        self.open(page)
        self.assertEqual(self.browser.evaluate("document.title"), "evil <b>&amp;.json")
        self.assertEqual(self.browser.evaluate("document.images.length"), 0)
        self.assertIn("<img", self.browser.evaluate("document.getElementById('tasks').textContent"))
        self.assert_quiet(page)

    def test_a_flight_is_drawn_beside_its_plan_and_its_estimate(self):
        task = self.folder / "task.yaml"
        task.write_text((SOURCE / "host/scenarios/clear/on_axis.yaml").read_text() + "\nthrust_reserve: 0.2\n")
        flown = subprocess.run([SSV, "fly", task, "--sim", "--conditions", "rough", "--format", "json"], capture_output=True, text=True)
        self.assertEqual(flown.returncode, OK, flown.stderr)
        flight = json.loads(flown.stdout)
        plan = json.loads(json.dumps(flight["plan"]), object_hook=lambda fields: SimpleNamespace(**fields))
        truth, estimate = (flight["flown"][key]["rows"] for key in ("truth", "estimate"))
        page = self.report(flown.stdout, "flight")
        self.assertAlmostEqual(self.open(page)["duration_s"], truth[-1][0], delta=1e-3)
        for part in (0.2, 0.5, 0.8):
            shown = self.slide(part * truth[-1][0])
            t_s = shown["time_s"]
            wanted, thought = between(truth, t_s), between(estimate, t_s)
            self.assertAlmostEqual(shown["plan_s"], thought[1], delta=1e-3)
            self.assertLess(math.dist(shown["X_IS"][:3], wanted[1:4]), POSE_M)
            self.assertLess(math.dist(shown["estimate"], thought[2:5]), POSE_M)
            p, q, *_ = sample(plan, shown["plan_s"])
            self.assertLess(math.dist(shown["predicted"][:3], p), POSE_M)
            self.assertLess(apart_rad(shown["predicted"][3:], q), POSE_RAD)
            following = next(row for row in estimate if row[0] > t_s)
            for u_N, commanded_N in zip(shown["u_N"], following[12:], strict=True):
                self.assertAlmostEqual(u_N, commanded_N, delta=THRUST_N)
        self.browser.screenshot(PICTURES / "flight.png")
        self.browser.press("End")
        self.assertTrue(self.state()["mated"])
        final = flight["plan"]["quote"]["X_IB_final"]["p_m"]
        self.assertLess(math.dist(self.state()["X_IB"][0][:3], final), DOCK_OFF_M)
        facts = self.browser.evaluate("document.getElementById('tables').textContent")
        for word in ("docked", "hit: ", "planned [s]", "conditions rough, seed 1"):
            self.assertIn(word, facts)
        self.assert_quiet(page)
        print(f"flight: {page.stat().st_size / 1e6:.2f} MB, {len(truth)} rows of truth, {len(estimate)} of the estimate", flush=True)

    def test_pictures_to_look_at(self):
        for name in ("clear/port2_either", "port3_oblique"):
            page = self.report(self.planned(SOURCE / f"host/scenarios/{name}.yaml"), Path(name).name)
            duration_s = self.open(page)["duration_s"]
            self.slide(0.6 * duration_s)
            self.browser.screenshot(PICTURES / f"{Path(name).name}.png")


class Assembly(InBrowser):
    """EASE, as `ssv schedule` has it built: all plans one after the other."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.assembly, cls.schedule = scheduled_tasks(SSV, SOURCE / "host/structures/ease.yaml")

    def test_the_tasks_are_those_of_the_schedule(self):
        self.assertEqual(len(self.assembly["tasks"]), 6)
        for task, part in zip(self.assembly["tasks"], self.schedule["subtasks"], strict=True):
            self.assertAlmostEqual(task["plan"]["quote"]["cost"], part["cost"], delta=1e-9 * part["cost"])  # the helper rounds otherwise

    def test_it_grows_task_by_task_and_every_pose_is_the_sampler_s(self):
        page = self.report(self.assembly, "ease")
        self.assertLessEqual(page.stat().st_size, ASSEMBLY_BYTES_MAX)
        print(f"ease: {page.stat().st_size / 1e6:.2f} MB", flush=True)
        state = self.open(page)
        self.assertLessEqual(max(state["in_view"]), 1)
        self.assertAlmostEqual(state["duration_s"], self.schedule["time_s"], delta=1e-3)
        start_s = 0
        for k, task in enumerate(self.assembly["tasks"]):
            for sample in self.samples(task, 2):
                state = self.slide(start_s + sample[0])
                self.assertEqual(state["task"], k)
                self.assert_shows(task, state, sample, start_s)
                for i, other in enumerate(self.assembly["tasks"]):  # what was carried stands, what comes later lies
                    rest = other["plan"]["quote"]["X_IB_final"] if i < k else other["scenario"]["X_IB"]
                    if i != k:
                        self.assertLess(math.dist(state["X_IB"][i][:3], rest["p_m"]), POSE_M)
                        self.assertLess(apart_rad(state["X_IB"][i][3:], rest["q"]), POSE_RAD)
            start_s += task["plan"]["quote"]["time_s"]
            if k == 3:
                self.browser.screenshot(PICTURES / "ease.png")
                self.browser.screenshot(PICTURES / "assembly.png", last="main")
        self.browser.press("End")
        self.assertTrue(self.state()["docked"])
        names = self.browser.evaluate("[...document.querySelectorAll('#labels span')].map(span => span.textContent)")
        self.assertEqual([name for name in names if name.startswith("obstacle")], [])
        self.assertEqual(names.count("hub"), 4)
        self.browser.screenshot(PICTURES / "ease_built.png")
        self.assertEqual(self.red_pixels(), 0)
        self.assert_quiet(page)

    def test_the_list_of_tasks_jumps_to_each_of_them(self):
        self.open(self.report(self.assembly))
        rows = "[...document.querySelectorAll('#tasks tbody tr')]"
        names = self.browser.evaluate(f"{rows}.map(row => row.cells[0].textContent)")
        self.assertEqual(names, [f"{k + 1}  {task['name']}" for k, task in enumerate(self.assembly["tasks"])])
        start_s = 0
        for k, task in enumerate(self.assembly["tasks"]):
            self.browser.evaluate(f"{rows}[{k}].click()" if k % 2 == 0 else f"{rows}[{k}].focus()")
            if k % 2 == 1:
                self.browser.press("Enter")
            self.assertEqual(self.state()["task"], k)
            self.assertAlmostEqual(self.state()["time_s"], start_s, delta=1e-3)
            self.assertEqual(self.browser.evaluate(f"{rows}.findIndex(row => row.classList.contains('at'))"), k)
            self.assertIn(task["name"], self.browser.evaluate("document.getElementById('tables').textContent"))
            start_s += task["plan"]["quote"]["time_s"]

    def test_a_pair_that_is_too_near_is_red_in_its_task_alone(self):
        assembly = json.loads(json.dumps(self.assembly))
        number = plant_ball(assembly["tasks"][3], 0.01)
        page = self.report(assembly, "planted")
        self.open(page)
        self.browser.press("c")
        state = self.state()
        self.assertEqual((state["task"], state["near"][1:3]), (3, [0, number]))
        self.assertAlmostEqual(state["near"][0], 0.01, delta=1e-4)
        self.assertTrue(state["closest_is_red"])
        self.assertGreater(self.red_pixels(), 10)
        self.assertIn(assembly["tasks"][3]["name"] + ": closer than the margin of 30 mm", self.browser.evaluate("document.getElementById('warning').textContent"))
        self.assertEqual(self.browser.evaluate("[...document.querySelectorAll('#tasks tbody tr')].map(row => row.querySelector('.below') !== null)"),
                         [False, False, False, True, False, False])
        self.browser.screenshot(PICTURES / "ease_planted.png")
        self.browser.evaluate("document.querySelector('#tasks tbody tr').click()")
        self.assertFalse(self.state()["closest_is_red"])
        self.assert_quiet(page)

    def test_flown_it_stays_small(self):
        flown = []
        for task in self.assembly["tasks"]:
            question = {"scenario": task["scenario"] | {"thrust_reserve": 0.2}, "scene": task["scene"]}
            done = subprocess.run([SSV, "fly", "-", "--sim", "--conditions", "rough", "--format", "json"], input=json.dumps(question),
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, OK, done.stderr)
            flown.append({"name": task["name"]} | json.loads(done.stdout))
        page = self.report(json.dumps({"tasks": flown}, indent=2), "ease_flown")
        self.assertLessEqual(page.stat().st_size, ASSEMBLY_BYTES_MAX)
        print(f"ease flown: {page.stat().st_size / 1e6:.2f} MB", flush=True)
        self.open(page)
        self.assertIn("6 of 6 docked", self.browser.evaluate("document.getElementById('headline').textContent"))
        state = self.slide(0.7 * self.state()["duration_s"])
        self.browser.screenshot(PICTURES / "ease_flown.png")
        for i, task in enumerate(flown[:state["task"]]):
            self.assertLess(math.dist(state["X_IB"][i][:3], task["plan"]["quote"]["X_IB_final"]["p_m"]), DOCK_OFF_M)
        self.assert_quiet(page)


@unittest.skipUnless(CHROMIUM, "needs Chromium (Debian package chromium)")
class WithoutThreeDimensions(InFolder):
    def test_tables_and_plots_are_there_without_webgl(self):
        page = self.report(self.planned(SCENARIOS[0]))
        with Browser(options=["--disable-3d-apis"]) as browser:
            browser.open(page.as_uri())
            browser.wait("window.ssv !== undefined")
            browser.press("End")
            state = browser.evaluate("ssv.state()")
            self.assertFalse(state["has_scene"])
            self.assertTrue(state["docked"])
            self.assertFalse(browser.evaluate("document.getElementById('no_picture').hidden"))
            self.assertEqual(browser.requests(), [page.as_uri()])


class Refused(InFolder):
    def test_a_file_that_holds_no_plan_is_refused_by_its_place(self):
        sound = self.planned(SCENARIOS[0])

        def broken(change):
            answer = json.loads(json.dumps(sound))
            change(answer["plan"], answer["scenario"])
            return answer

        cases = [("{", "not JSON"), ({"plan": {}}, "plan"), ({"tasks": []}, "must be a list of 1 to"), ({"tasks": [{}]}, "missing"),
                 ({"scenario": sound["scenario"]}, "plan: this key is missing"),
                 ({"plan": sound["plan"]}, "scenario: this key is missing"),
                 (broken(lambda plan, _: plan["legs"][1].update(first_arc=60)), "plan.legs[1]"),
                 (broken(lambda plan, _: plan["legs"][0]["X_IS_start"].update(q=[0, 0, 0, 0])), "plan.legs[0]"),
                 (broken(lambda plan, _: plan["quote"].update(time_s=-1)), "time_s"),
                 (broken(lambda plan, _: plan.update(num_events=0, events=[])), "two events"),
                 (broken(lambda plan, _: plan["arcs"][0].update(dv_dt=[1e300, 1e300, 1e300], v_start=1e308)), "its arcs lead to no motion"),
                 (broken(lambda _, scenario: scenario["vehicle"].update(radius_m=-1)), "scenario.vehicle.radius_m")]
        for content, said in cases:
            with self.subTest(said):
                self.assertIn(said, self.report(content, code=REFUSED))
        answer = subprocess.run([SSV, "plan", "-", "--format", "json"], input="model: paper", capture_output=True, text=True).stdout
        self.assertIn("there is no plan", self.report(answer, code=REFUSED))

    def test_wrong_arguments_and_help(self):
        for arguments, said in (([], "which file?"), (["a", "b"], "one file at a time"), (["--wrong"], "--wrong")):
            done = subprocess.run([SSV, "report", *arguments], capture_output=True, text=True)
            self.assertEqual(done.returncode, USAGE)
            self.assertIn(said, done.stderr)
        done = subprocess.run([SSV, "report", "--help"], capture_output=True, text=True, check=True)
        for word in ("Examples:", "Exit codes:", "--output"):
            self.assertIn(word, done.stdout)
        done = subprocess.run([SSV, "report", "/nowhere.json"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (REFUSED, ""))
        self.assertIn("/nowhere.json", done.stderr)

    def test_an_output_that_cannot_be_written_is_told(self):
        answer = self.planned(SCENARIOS[0])
        (self.folder / "plan.json").write_text(json.dumps(answer))
        done = subprocess.run([SSV, "report", self.folder / "plan.json", "--output", "/nowhere/plan.html"], capture_output=True, text=True)
        self.assertEqual(done.returncode, FAILED)
        self.assertIn("/nowhere/plan.html", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
