"""ssv plan and ssv quote from the outside: what users and their scripts rely on."""
import itertools
import json
import math
import os
import random
import re
import resource
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm

BIN = Path(os.environ["SSV_BIN_DIR"])
HOST = Path(os.environ["SSV_SOURCE_DIR"]) / "host"
SCENARIOS = sorted((HOST / "scenarios").glob("*.yaml"))
PAPER_CASE = HOST / "scenarios" / "paper_case.yaml"
PORT1 = HOST / "scenarios" / "port1_contact2.yaml"

# Ports of our own, so that tests which run at the same time do not hear one another.
LCM_PORT = 20000 + os.getpid() % 20000
URL = f"udpm://239.255.76.67:{LCM_PORT}?ttl=0"
SILENT_URL = f"udpm://239.255.76.67:{LCM_PORT + 20000}?ttl=0"


def ssv(*arguments, **options):
    return subprocess.run([BIN / "ssv", *map(str, arguments)], capture_output=True, text=True, timeout=60, **options)


def edited(text, *changes):
    for old, new in changes:
        if text.count(old) < 1:
            raise ValueError(f"'{old}' is not in the file")
        text = text.replace(old, new, 1)
    return text


def without_stamp(plan):
    """The answer without what differs from run to run by intent."""
    plan = json.loads(json.dumps(plan))
    del plan["request_id"], plan["scenario"]["request_id"], plan["scenario"]["epoch_us"]
    return plan


class Daemon:
    def __init__(self, url, program="ssv-plannerd"):
        self._url = url
        self._program = program

    def __enter__(self):
        self.process = subprocess.Popen([BIN / self._program, "--lcm-url", self._url], stderr=subprocess.DEVNULL)
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(timeout=10)


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def scenario(self, *changes, base=PAPER_CASE):
        path = self.folder / "task.yaml"
        path.write_text(edited(base.read_text(), *changes))
        return path

    def scenario_with_model(self, *changes):
        (self.folder / "mine.yaml").write_text(edited((HOST / "models" / "ease.yaml").read_text(), *changes))
        return self.scenario(("model: ease", "model: mine.yaml"), base=PORT1)

    def assert_refused(self, path, *words, arguments=()):
        """Exit code 2, a sentence with these words on standard error, and the same in the JSON."""
        done = ssv("plan", path, *arguments)
        self.assertEqual(done.returncode, 2, done)
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        done = ssv("plan", path, "--format", "json", *arguments)
        self.assertEqual(done.returncode, 2, done)
        answer = json.loads(done.stdout)
        self.assertEqual(list(answer), ["status", "reason"])
        self.assertEqual(answer["status"], "invalid")
        for word in words:
            self.assertIn(word, answer["reason"])
            self.assertIn(word, done.stderr)


class BadInputTest(InFolder):
    def test_values_that_make_no_sense_are_refused_by_the_name_of_their_field(self):
        for change, field in [
            (("p_IS_m: [0, 0, 0]", "p_IS_m: [0, .nan, 0]"), "vehicle.p_IS_m: nan"),
            (("p_IB_m: [5, 0, 0]", "p_IB_m: [.inf, 0, 0]"), "beam.p_IB_m: inf"),
            (("p_IP_m: [6.524, 5, 0]", "p_IP_m: [6.524, -.inf, 0]"), "port.p_IP_m: -inf"),
            (("p_IP_m: [6.524, 5, 0]", "p_IP_m: [6.524, 5000, 0]"), "port.p_IP_m: 5000 is outside its range"),
            (("standoff_m: 0.3025", "standoff_m: 1e999"), "standoff_m: inf"),
            (("standoff_m: 0.3025", "standoff_m: 0"), "standoff_m: 0 is outside its range"),
            (("q_IS: [0, 0, 0, 1]", "q_IS: [0, 0, 0, 0]"), "vehicle.q_IS: length 0"),
            (("q_IS: [0, 0, 0, 1]", "q_IS: [0, 0, 0, 1.002]"), "vehicle.q_IS: length 1.002"),
            (("q_IB: [0.7071067811865476,", "q_IB: [0.8,"), "beam.q_IB: length"),
            (("axis_I: [0, -1, 0]", "axis_I: [0, -1, 1]"), "port.axis_I: length"),
            (("{time: 1, impulse: 1}", "{time: -1, impulse: 1}"), "weights.time: -1"),
            (("{time: 1, impulse: 1}", "{time: 1, impulse: -0.5}"), "weights.impulse: -0.5"),
            (("{time: 1, impulse: 1}", "{time: 0, impulse: 0}"), "weights: both are zero"),
            (("ring_angle_rad: -1.57", "ring_angle_rad: -7.57"), "ring_angle_rad: -7.57"),
            (("model: paper", "model: paper\nattach_heights_m: [0, 1.6]"), "attach_heights_m[1]: 1.6 is outside its range"),
        ]:
            with self.subTest(field):
                self.assert_refused(self.scenario(change), field)

    def test_a_model_that_makes_no_sense_is_refused_by_the_name_of_its_field(self):
        for change, field in [
            (("mass_kg: 76.2", "mass_kg: 0"), "vehicle.mass_kg: 0 is outside its range"),
            (("mass_kg: 11.3636", "mass_kg: -1"), "beam.mass_kg: -1"),
            (("[2.7, 2.7, 2.7]", "[2.7, .nan, 2.7]"), "vehicle.inertia_kg_m2: nan"),
            (("length_m: 3.048", "length_m: 0"), "beam.length_m: 0"),
            (("drag_strip_kg_m2: 66.66", "drag_strip_kg_m2: -1"), "beam.drag_strip_kg_m2: -1"),
            (("n_T_S: [1, 0, 0]", "n_T_S: [1, 1, 0]"), "vehicle.thrusters[0].n_T_S: length"),
            (("n_T_S: [0, 1, 0]", "n_T_S: [1, 0, 0]"), "vehicle.thrusters"),
            (("axis_H: [0.5, 0", "axis_H: [0.6, 0"), "hub.ports[0].axis_H: length"),
            (("p_HP_m: [0.1905", "p_HP_m: [.nan"), "hub.ports[0].p_HP_m: nan"),
        ]:
            with self.subTest(field):
                self.assert_refused(self.scenario_with_model(change), field)

    def test_text_where_a_number_belongs_is_refused(self):
        for text in ("1,5", "1.5m", "0x10", "abc", "''", "~", "1e", "--1", "inf"):
            with self.subTest(text):
                change = ("standoff_m: 0.3025", f"standoff_m: {text}")
                self.assert_refused(self.scenario(change), "standoff_m", "is not a number")

    def test_a_word_that_is_no_choice_is_refused_with_the_choices(self):
        self.assert_refused(self.scenario(("contact: 1", "contact: 3")), "beam.contact: '3'", "either, 1, 2")
        self.assert_refused(self.scenario(("port: 1", "port: 4"), base=PORT1), "hub.port: '4'", "1, 2, 3")
        for key, word, choices in (("method", "fastest", "optimal, paper"), ("effort", "1", "quick, best"),
                                   ("candidates", "yes", "false, true"), ("front", "1", "false, true"),
                                   ("attach_anywhere", "on", "false, true")):
            path = self.scenario(("model: paper", f"model: paper\n{key}: {word}"))
            self.assert_refused(path, f"{key}: '{word}' is none of {choices}")

    def test_the_hub_is_checked_though_the_planner_never_sees_it(self):
        self.assert_refused(self.scenario(("q_IH: [1, 0, 0, 0]", "q_IH: [0, 0, 0, 0]"), base=PORT1), "hub.q_IH: length 0")
        self.assert_refused(self.scenario(("p_IH_m: [5, 3, 0.5]", "p_IH_m: [5, .inf, 0.5]"), base=PORT1), "hub.p_IH_m: inf")

    def test_an_unknown_a_missing_and_a_repeated_key_are_named_with_their_line(self):
        for change, words in [
            (("standoff_m:", "standof_m:"), ["standof_m: unknown key", "task.yaml:15"]),
            (("{time: 1, impulse: 1}", "{time: 1, impulse: 1, fuel: 2}"), ["weights.fuel: unknown key", "task.yaml:16"]),
            (("  contact: 1\n", ""), ["beam.contact: this key is missing"]),
            (("{time: 1, impulse: 1}", "{}"), ["weights.", "this key is missing"]),
            (("model: paper\n", ""), ["model: this key is missing"]),
            (("contact: 1", "contact: 1\n  contact: 2"), ["beam.contact: this key stands there twice"]),
        ]:
            with self.subTest(words[0]):
                self.assert_refused(self.scenario(change), "task.yaml", *words)
        port = "port:\n  p_IP_m: [6.524, 5, 0]\n  axis_I: [0, -1, 0]\n"
        self.assert_refused(self.scenario((port, "")), "port: this key is missing", "hub")
        hub = "hub: {p_IH_m: [0, 0, 0], q_IH: [1, 0, 0, 0], port: 1}\n"
        self.assert_refused(self.scenario((port, port + hub)), "hub: port is given too")

    def test_keys_of_the_model_file_are_held_to_the_same(self):
        for change, words in [
            (("n_T_S: [1, 0, 0]", "n_TS: [1, 0, 0]"), ["mine.yaml:", "vehicle.thrusters[0].n_TS: unknown key"]),
            (("  length_m: 3.048 ", "#"), ["mine.yaml:", "beam.length_m: this key is missing"]),
            (("    - {p_ST_m: [0, -0.3025, 0], n_T_S: [0, 0, -1]}\n", ""), ["mine.yaml:", "vehicle.thrusters: 5 entries"]),
            (("n_T_S: [1, 0, 0]", "n_T_S: [1, x, 0]"), ["mine.yaml:", "vehicle.thrusters[0].n_T_S[1]: 'x' is not a number"]),
        ]:
            with self.subTest(words[1]):
                self.assert_refused(self.scenario_with_model(change), *words)

    def test_a_list_of_the_wrong_length_is_refused(self):
        self.assert_refused(self.scenario(("[0, 0, 0, 1]", "[0, 0, 1]")), "vehicle.q_IS: 3 entries")
        self.assert_refused(self.scenario(("[0, 0, 0, 1]", "[0, 0, 0, 1, 0]")), "vehicle.q_IS: more than 4 entries")
        none, nine = ("model: paper\nattach_heights_m: [" + ", ".join("0" * count) + "]" for count in (0, 9))
        self.assert_refused(self.scenario(("model: paper", none)), "attach_heights_m: 0 entries")
        self.assert_refused(self.scenario(("model: paper", nine)), "attach_heights_m: more than 8 entries")

    def test_an_unknown_model_is_refused_with_the_names_there_are(self):
        self.assert_refused(self.scenario(("model: paper", "model: papper")), "model: 'papper'", "ease, paper")
        self.assert_refused(self.scenario(("model: paper", "model: no/such.yaml")), "no/such.yaml: cannot open")

    def test_a_file_that_is_no_scenario_is_refused_by_its_name(self):
        contents = {
            "empty.yaml": b"",
            "comment.yaml": b"# nothing\n",
            "binary.yaml": bytes(range(256)) * 64,
            "noise.yaml": random.Random(1).randbytes(4096),
            "list.yaml": b"[1, 2, 3]\n",
            "word.yaml": b"hello\n",
            "unclosed.yaml": b"model: [paper\n",
            "two.yaml": PAPER_CASE.read_bytes() + b"---\n" + PAPER_CASE.read_bytes(),
            "deep.yaml": b"model: " + b"[" * 100000,
            "huge.yaml": PAPER_CASE.read_bytes() + b"#" * (1 << 20),
        }
        for name, content in contents.items():
            (self.folder / name).write_bytes(content)
        (self.folder / "folder.yaml").mkdir()
        for name in [*contents, "folder.yaml", "absent.yaml"]:
            with self.subTest(name):
                self.assert_refused(self.folder / name, name)

    def test_text_of_the_file_cannot_steer_the_terminal(self):
        done = ssv("plan", self.scenario(("model: paper", 'model: "\\e[31mred\\n"')))
        self.assertEqual(done.returncode, 2)
        self.assertNotIn("\x1b", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_quaternions_within_a_thousandth_of_unit_length_are_taken(self):
        self.assertEqual(ssv("plan", self.scenario(("[0, 0, 0, 1]", "[0, 0, 0, 1.0009]"))).returncode, 0)

    def test_a_task_that_takes_too_long_is_infeasible_with_a_reason_per_candidate(self):
        path = self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        done = ssv("plan", path, "--format", "json")
        self.assertEqual(done.returncode, 3, done)
        answer = json.loads(done.stdout)
        self.assertEqual(
            list(answer), ["status", "reason", "request_id", "candidates", "scenario_hash", "scenario"])
        self.assertEqual(answer["status"], "infeasible")
        self.assertEqual(len(answer["candidates"]), 3)
        for candidate in answer["candidates"]:
            self.assertIn("longest plan", candidate["reason"])
        done = ssv("plan", path)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stdout.count("not feasible: "), 3)


class UsageTest(InFolder):
    def test_wrong_arguments_are_told_from_wrong_scenarios(self):
        for arguments in [
            [],
            ["fly"],
            ["plan"],
            ["plan", PAPER_CASE, PAPER_CASE],
            ["plan", PAPER_CASE, "--wieghts", "1,1"],
            ["plan", PAPER_CASE, "--weights", "1"],
            ["plan", PAPER_CASE, "--weights", "1;2"],
            ["plan", PAPER_CASE, "--weights", "a,b"],
            ["plan", PAPER_CASE, "--method", "best"],
            ["plan", PAPER_CASE, "--method", ""],
            ["plan", PAPER_CASE, "--effort", "paper"],
            ["plan", PAPER_CASE, "--scalar", "half"],
            ["plan", PAPER_CASE, "--format", "xml"],
            ["plan", PAPER_CASE, "--lcm", "--timeout", "0"],
            ["plan", PAPER_CASE, "--lcm", "--timeout", ".nan"],
            ["plan", PAPER_CASE, "--candidates=yes"],
            ["quote"],
            ["quote", *[PAPER_CASE] * 17],
            ["quote", PAPER_CASE, "--front=all"],
        ]:
            with self.subTest(arguments):
                done = ssv(*arguments)
                self.assertEqual(done.returncode, 64, done)
                self.assertEqual(done.stdout, "")
                self.assertIn("ssv", done.stderr)

    def test_help_has_examples_and_every_exit_code(self):
        for command in ("plan", "quote"):
            done = ssv(command, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("Examples:", done.stdout)
            codes = [line.split()[0] for line in re.split("Exit codes.*:", done.stdout)[1].splitlines() if line.strip()]
            self.assertEqual(sorted(code for code in codes if code.isdigit()), ["0", "1", "2", "3", "4", "5", "64"])
            self.assertLessEqual(max(map(len, done.stdout.splitlines())), 80)
            self.assertIn(f"  {command} ", ssv("--help").stdout)

    def test_version_is_that_of_the_daemon(self):
        daemon = subprocess.run([BIN / "ssv-plannerd", "--version"], capture_output=True, text=True, timeout=60)
        self.assertEqual(ssv("--version").stdout.split()[1:], daemon.stdout.split()[1:])

    def test_weights_of_the_command_line_count_over_those_of_the_file(self):
        plan = json.loads(ssv("plan", PAPER_CASE, "--weights", "0.5,2e-1", "--format", "json").stdout)
        self.assertEqual(plan["scenario"]["weights"], {"time": 0.5, "impulse": 0.2})
        self.assertAlmostEqual(plan["cost"]["J"], 0.5 * plan["cost"]["time_s"] + 0.2 * plan["cost"]["impulse_Ns"], 9)
        done = ssv("plan", PAPER_CASE, "--weights", "-1,0")
        self.assertEqual(done.returncode, 2)
        self.assertIn("weights.time: -1", done.stderr)

    def test_method_and_effort_come_from_the_command_line_else_from_the_file_else_from_the_defaults_in_the_help(self):
        def used(path, *arguments):
            scenario = json.loads(ssv("plan", path, "--format", "json", *arguments).stdout)["scenario"]
            return scenario["method"], scenario["effort"]

        described = " ".join(ssv("plan", "--help").stdout.split())
        defaults = tuple(re.search(rf"--{key}=.*?\(default (\w+)\)", described)[1] for key in ("method", "effort"))
        self.assertEqual(used(PAPER_CASE), defaults)
        for method in ("optimal", "paper"):
            for effort in ("quick", "best"):
                of_file = self.scenario(("model: paper", f"model: paper\nmethod: {method}\neffort: {effort}"))
                self.assertEqual(used(of_file), (method, effort))
                self.assertEqual(used(PAPER_CASE, "--method", method, "--effort", effort), (method, effort))
                self.assertEqual(used(of_file, "--method", "paper"), ("paper", effort))
                self.assertEqual(used(of_file, "--effort", "quick"), (method, "quick"))

    def test_a_scenario_may_come_through_a_pipe(self):
        done = ssv("plan", "/dev/stdin", "--format", "json", input=PAPER_CASE.read_text())
        self.assertEqual(done.returncode, 0, done)

    def test_a_model_path_counts_from_the_scenario_file(self):
        (self.folder / "models").mkdir()
        (self.folder / "models" / "mine.yaml").write_text((HOST / "models" / "paper.yaml").read_text())
        by_path = ssv("plan", self.scenario(("model: paper", "model: models/mine.yaml")), "--format", "json", cwd="/")
        by_name = ssv("plan", PAPER_CASE, "--format", "json")
        self.assertEqual(without_stamp(json.loads(by_path.stdout)), without_stamp(json.loads(by_name.stdout)))


def shape(value):
    """The keys and the kinds of values; of a list what all its elements have in common."""
    if isinstance(value, dict):
        return {key: shape(element) for key, element in value.items()}
    if isinstance(value, list):
        shapes = [shape(element) for element in value]
        if any(element != shapes[0] for element in shapes):
            raise AssertionError(f"elements differ: {value}")
        return [len(value) if shapes and shapes[0] == "real" else "any", shapes[0]] if shapes else []
    return {float: "real", int: "integer", str: "text", bool: "flag", type(None): "null"}[type(value)]


V3, Q4, U6 = [3, "real"], [4, "real"], [6, "real"]
POSE_S, POSE_B = {"p_IS_m": V3, "q_IS": Q4}, {"p_IB_m": V3, "q_IB": Q4}
BODY = {"mass_kg": "real", "inertia_kg_m2": V3, "added_mass_kg": V3, "drag_lin_kg_s": "real", "drag_quad_kg_m": "real",
        "drag_lin_ang_Nm_s": "real", "drag_quad_ang_Nm_s2": "real"}
PLAN_SHAPE = {
    "status": "text", "reason": "text", "request_id": "integer",
    "cost": {"J": "real", "J_lower_bound": "real", "time_s": "real", "impulse_Ns": "real"},
    "choice": {"beam_contact": "integer", "attach_height_m": "real", "ring_angle_rad": "real", "candidates": "integer"},
    "phases": ["any", {"name": "text", "time_s": "real", "impulse_Ns": "real"}],
    "legs": ["any", {"phase": "text", "kind": "text", "ramp": "text", "t_start_s": "real", "duration_s": "real",
                     "impulse_Ns": "real", "peak_speed": "real", "pose_start": POSE_S, "pose_end": POSE_S}],
    "timeline": {"segments": ["any", {"t_s": "real", "duration_s": "real", "u_start_N": U6, "u_end_N": U6,
                                      "leg": "integer"}]},
    "events": ["any", {"t_s": "real", "kind": "text"}],
    "final": {"vehicle": POSE_S, "beam": POSE_B},
    "scenario_hash": "text", "plan_hash": "text",
    "scenario": {
        "request_id": "integer", "epoch_us": "integer",
        "vehicle": BODY | {"radius_m": "real", "force_max_N": "real", "thrusters": ["any", {"p_ST_m": V3, "n_T_S": V3}]},
        "beam": BODY | {"radius_m": "real", "length_m": "real", "drag_strip_kg_m2": "real"},
        "X_IS": POSE_S, "X_IB": POSE_B, "port": {"p_IP_m": V3, "axis_I": V3}, "contact": "integer", "standoff_m": "real",
        "weights": {"time": "real", "impulse": "real"}, "attach_heights_m": [], "attach_anywhere": "flag",
        "ring_angle_rad": "null", "method": "text", "effort": "text", "want_candidates": "flag", "want_front": "flag",
    },
}


METHODS = {"paper": ["--method", "paper"], "optimal": ["--method", "optimal"],
           "optimal best": ["--method", "optimal", "--effort", "best"]}


class PlanJsonTest(InFolder):
    @classmethod
    def setUpClass(cls):
        """Of each scenario the plan by each method."""
        cls.plans = {(path.stem, method): json.loads(ssv("plan", path, "--format", "json", *arguments).stdout)
                     for path in SCENARIOS for method, arguments in METHODS.items()}

    def test_every_scenario_gives_the_documented_keys_and_no_others(self):
        self.assertEqual(len(self.plans), 5 * 3)
        for (name, method), plan in self.plans.items():
            with self.subTest(f"{name} {method}"):
                expected = json.loads(json.dumps(PLAN_SHAPE))
                if name == "paper_case":
                    expected["scenario"]["ring_angle_rad"] = "real"
                if name == "port2_either":
                    expected["scenario"]["attach_heights_m"] = [3, "real"]
                self.assertEqual(shape(plan), expected)

    def test_the_parts_of_a_plan_agree_with_one_another(self):
        for task, plan in self.plans.items():
            with self.subTest(" ".join(task)):
                self.assertEqual((plan["status"], plan["reason"]), ("ok", ""))
                self.assertEqual([event["kind"] for event in plan["events"]], ["mate", "dock"])
                self.assertEqual([phase["name"] for phase in plan["phases"]], ["transit", "transfer"])
                for total in ("time_s", "impulse_Ns"):
                    of_phases = sum(phase[total] for phase in plan["phases"])
                    self.assertTrue(math.isclose(of_phases, plan["cost"][total], rel_tol=1e-12), total)
                self.assertTrue(0 <= plan["cost"]["J_lower_bound"] <= plan["cost"]["J"])
                self.assertAlmostEqual(plan["events"][0]["t_s"], plan["phases"][0]["time_s"], 9)
                self.assertAlmostEqual(plan["events"][1]["t_s"], plan["cost"]["time_s"], 9)
                self.assertEqual(plan["legs"][-1]["pose_end"], plan["final"]["vehicle"])
                for hash_key in ("scenario_hash", "plan_hash"):
                    self.assertRegex(plan[hash_key], "^[0-9a-f]{16}$")

    def test_the_scenarios_cover_every_port_every_contact_and_a_tie(self):
        texts = {path.stem: path.read_text() for path in SCENARIOS}
        for choice in ("port: 1", "port: 2", "port: 3", "contact: 1", "contact: 2", "contact: either"):
            self.assertTrue(any(f"  {choice}\n" in text for text in texts.values()), choice)
        self.assertGreaterEqual(self.plans["on_axis", "paper"]["choice"]["candidates"], 2 * 3 * 16)

    def test_method_optimal_costs_no_more_than_paper(self):
        for path in SCENARIOS:
            with self.subTest(path.stem):
                paper, quick, best = (self.plans[path.stem, method]["cost"]["J"] for method in METHODS)
                self.assertLessEqual(quick, paper)
                self.assertLessEqual(best, paper)

    def test_the_hub_gives_the_port_that_its_pose_and_the_model_say(self):
        # By hand: no turn; half a turn about x (x, -y, -z); a quarter turn about y (z, y, -x).
        low, high, up = 0.0952500, 0.1649778394209356, 0.3299556788418712
        for name, expected in [
            ("port1_contact2", [5 + 2 * low, 3, 0.5 + up]),
            ("port2_either", [-4 - low, 3 - high, -1 - up]),
            ("on_axis", [3 + up, 2, -2 * low]),
        ]:
            port = self.plans[name, "paper"]["scenario"]["port"]
            hub = {"port1_contact2": [5, 3, 0.5], "port2_either": [-4, 3, -1], "on_axis": [3, 2, 0]}[name]
            for i in range(3):
                self.assertAlmostEqual(port["p_IP_m"][i], expected[i], 12, name)
                self.assertAlmostEqual(port["axis_I"][i], (expected[i] - hub[i]) / 0.381, 12, name)

    def test_standoff_defaults_to_the_sum_of_the_radii(self):
        self.assertAlmostEqual(self.plans["on_axis", "paper"]["scenario"]["standoff_m"], 0.3025 + 0.0606, 15)

    def test_the_docked_beam_ends_on_the_port_and_points_into_it(self):
        for task, plan in self.plans.items():
            with self.subTest(" ".join(task)):
                w, x, y, z = plan["final"]["beam"]["q_IB"]
                z_B = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
                outward = -1 if plan["choice"]["beam_contact"] == 1 else 1
                half_m = plan["scenario"]["beam"]["length_m"] / 2
                for i in range(3):
                    contact = plan["final"]["beam"]["p_IB_m"][i] + outward * half_m * z_B[i]
                    self.assertAlmostEqual(contact, plan["scenario"]["port"]["p_IP_m"][i], 9)
                    self.assertAlmostEqual(outward * z_B[i], -plan["scenario"]["port"]["axis_I"][i], 9)

    def test_numbers_survive_the_file_bit_for_bit(self):
        self.assertEqual(self.plans["paper_case", "paper"]["scenario"]["ring_angle_rad"], -1.5707963267948966)
        self.assertEqual(self.plans["paper_case", "paper"]["scenario"]["X_IB"]["q_IB"][0], 0.7071067811865476)

    def test_the_table_shows_the_same_plan(self):
        for (name, method), plan in self.plans.items():
            with self.subTest(f"{name} {method}"):
                table = ssv("plan", HOST / "scenarios" / f"{name}.yaml", *METHODS[method]).stdout
                self.assertIn(f"= {plan['cost']['J']:.3f}\n", table)
                self.assertIn(plan["plan_hash"], table)
                self.assertLessEqual(max(map(len, table.splitlines())), 120)

    def test_the_table_tells_the_lower_bound_and_how_far_off_the_plan_can_be(self):
        for (name, method), plan in self.plans.items():
            with self.subTest(f"{name} {method}"):
                table = ssv("plan", HOST / "scenarios" / f"{name}.yaml", *METHODS[method]).stdout
                least = plan["cost"]["J_lower_bound"]
                self.assertIn(f"No plan of any kind costs less than {least:.3f}", table)
                self.assertIn(f"at most {100 * (plan['cost']['J'] / least - 1):.1f} % above the best possible", table)


CANDIDATE_SHAPE = {"beam_contact": "integer", "attach_height_m": "real", "ring_angle_rad": "real", "reason": "text",
                   "time_s": "real", "impulse_Ns": "real", "J": "real"}
POINT_SHAPE = {"time_s": "real", "impulse_Ns": "real", "J": "real", "beam_contact": "integer", "attach_height_m": "real",
               "ring_angle_rad": "real"}


class CandidatesAndFrontTest(InFolder):
    def answer(self, command, path, *arguments):
        answer = json.loads(ssv(command, path, "--format", "json", *arguments).stdout)
        return answer["quotes"][0] if command == "quote" else answer

    def test_candidates_and_front_come_only_on_request_of_the_command_line_or_of_the_file(self):
        of_file = {"candidates": False, "front": False}
        for key in of_file:
            path = self.scenario(("model: paper", f"model: paper\n{key}: true"))
            off = self.folder / "off.yaml"
            off.write_text(path.read_text().replace("true", "false"))
            for command in ("plan", "quote"):
                with self.subTest(f"{command} {key}"):
                    asked = self.answer(command, PAPER_CASE, f"--{key}")
                    self.assertEqual({k: k in asked for k in of_file}, of_file | {key: True})
                    self.assertEqual(self.answer(command, path)[key], asked[key])
                    for answer in (self.answer(command, PAPER_CASE), self.answer(command, off)):
                        self.assertFalse(of_file.keys() & answer.keys())
                        self.assertEqual(answer["cost"], asked["cost"])

    def test_every_contact_and_height_is_a_candidate_and_the_quote_is_the_cheapest(self):
        for path, method in itertools.product(SCENARIOS, METHODS):
            with self.subTest(f"{path.stem} {method}"):
                answer = self.answer("plan", path, "--candidates", *METHODS[method])
                self.assertEqual(shape(answer["candidates"]), ["any", CANDIDATE_SHAPE])
                asked = answer["scenario"]
                heights = asked["attach_heights_m"] or [1.524, 0, -1.524]
                contacts = [asked["contact"]] if asked["contact"] else [1, 2]
                self.assertEqual([(c["beam_contact"], c["attach_height_m"]) for c in answer["candidates"]],
                                 list(itertools.product(contacts, heights)))
                self.assertEqual(min(c["J"] for c in answer["candidates"] if not c["reason"]), answer["cost"]["J"])
                quote = self.answer("quote", path, "--candidates", *METHODS[method])
                self.assertEqual(quote["candidates"], answer["candidates"])
                for command in ("plan", "quote"):
                    table = ssv(command, path, "--candidates", *METHODS[method]).stdout
                    self.assertEqual(table.count("  chosen\n"), 1)
                    self.assertEqual(ssv(command, path, *METHODS[method]).stdout.count("chosen"), 0)

    def test_anywhere_along_the_beam_is_cheaper_than_at_the_heights_given_and_the_table_still_has_the_choice(self):
        # Held a little off the middle the beam takes less time to turn.
        anywhere = self.scenario(("model: paper", "model: paper\nattach_anywhere: true"))
        given = self.answer("quote", PAPER_CASE, "--weights", "1,0")
        freed = self.answer("quote", anywhere, "--weights", "1,0", "--candidates")
        self.assertLess(freed["cost"]["J"], 0.998 * given["cost"]["J"])
        self.assertLessEqual(freed["cost"]["J_lower_bound"], given["cost"]["J_lower_bound"])
        height = freed["choice"]["attach_height_m"]
        self.assertLess(abs(height), 1.524)
        self.assertEqual([c["attach_height_m"] for c in freed["candidates"]], [1.524, 0, -1.524])
        self.assertNotIn(height, [1.524, 0, -1.524])
        table = ssv("quote", anywhere, "--weights", "1,0", "--candidates").stdout
        self.assertRegex(table, rf"\n +1 +{re.escape(f'{height:+.4f}')} .*  chosen\n")
        self.assertEqual(table.count("  chosen\n"), 1)

    def test_no_point_of_a_front_is_better_than_another_in_both_and_it_is_no_worse_than_the_quote(self):
        for path, weights in itertools.product(SCENARIOS, ("1,0", "1,0.1", "1,1", "0,1")):
            with self.subTest(f"{path.stem} {weights}"):
                answer = self.answer("quote", path, "--front", "--weights", weights, "--method", "optimal")
                front, cost = answer["front"], answer["cost"]
                self.assertEqual(shape(front), ["any", POINT_SHAPE])
                for one, another in itertools.permutations(front, 2):
                    self.assertFalse(one["time_s"] <= another["time_s"] and one["impulse_Ns"] <= another["impulse_Ns"])
                self.assertEqual(front, sorted(front, key=lambda point: point["time_s"]))
                self.assertTrue(any(point["time_s"] <= cost["time_s"] and point["impulse_Ns"] <= cost["impulse_Ns"]
                                    for point in front))
                w1, w2 = map(float, weights.split(","))
                for point in front:
                    self.assertAlmostEqual(point["J"], w1 * point["time_s"] + w2 * point["impulse_Ns"], 8)
                table = ssv("quote", path, "--front", "--weights", weights, "--method", "optimal").stdout
                for point in front:
                    self.assertRegex(table, rf"{point['time_s']:.3f} +{point['impulse_Ns']:.3f} ")


class QuoteTest(InFolder):
    def quotes(self, paths, *arguments, code=0):
        done = ssv("quote", *paths, "--format", "json", *arguments)
        self.assertEqual(done.returncode, code, done)
        quotes = json.loads(done.stdout)["quotes"]
        self.assertEqual([quote["file"] for quote in quotes], list(map(str, paths)))
        return quotes

    def other(self, name, *changes):
        path = self.folder / name
        path.write_text(edited(PAPER_CASE.read_text(), *changes))
        return path

    def test_a_quote_is_the_price_of_the_plan_to_the_last_bit(self):
        for method, weights in itertools.product(METHODS, ("1,0", "0,1", "1,1")):
            arguments = [*METHODS[method], "--weights", weights]
            for path, quote in zip(SCENARIOS, self.quotes(SCENARIOS, *arguments)):
                with self.subTest(f"{path.stem} {method} {weights}"):
                    plan = json.loads(ssv("plan", path, "--format", "json", *arguments).stdout)
                    self.assertEqual(list(quote), ["file", "status", "reason", "request_id", "cost", "choice",
                                                   "scenario_hash", "scenario"])
                    for key in ("status", "reason", "cost", "choice", "scenario_hash"):
                        self.assertEqual(quote[key], plan[key])
                    self.assertEqual(without_stamp(quote)["scenario"], without_stamp(plan)["scenario"])

    def test_the_table_has_a_row_for_each_file_with_the_same_numbers(self):
        lines = ssv("quote", *SCENARIOS).stdout.splitlines()
        self.assertEqual(len(lines), 1 + len(SCENARIOS))
        self.assertEqual(len({len(line) for line in lines}), 1)
        self.assertEqual(re.split("  +", lines[0]),
                         ["scenario", "J", "time s", "impulse N s", "lower bound", "gap %", "contact", "height m"])
        for line, path, quote in zip(lines[1:], SCENARIOS, self.quotes(SCENARIOS)):
            cost, choice = quote["cost"], quote["choice"]
            gap = 100 * (cost["J"] / cost["J_lower_bound"] - 1)
            prices = [f"{cost[key]:.3f}" for key in ("J", "time_s", "impulse_Ns", "J_lower_bound")]
            where = [str(choice["beam_contact"]), f"{choice['attach_height_m']:+.4f}"]
            self.assertEqual(line.split(), [str(path), *prices, f"{gap:.1f}", *where])

    def test_a_task_that_is_refused_or_has_no_plan_leaves_the_others_alone_and_the_worst_decides_the_exit_code(self):
        far = self.other("far.yaml", ("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        bad = self.other("bad.yaml", ("standoff_m: 0.3025", "standoff_m: .nan"))
        typo = self.other("typo.yaml", ("standoff_m", "standof_m"))
        alone = {path: self.quotes([path], code=code)[0] for path, code in ((PAPER_CASE, 0), (far, 3), (bad, 2), (typo, 2))}
        self.assertEqual([quote["status"] for quote in alone.values()], ["ok", "infeasible", "invalid", "invalid"])
        self.assertEqual(list(alone[far]),
                         ["file", "status", "reason", "request_id", "candidates", "scenario_hash", "scenario"])
        self.assertEqual(list(alone[bad]), ["file", "status", "reason"])
        same = lambda quote: {key: quote[key] for key in quote if key not in ("request_id", "scenario")}
        for paths, code in (([far, PAPER_CASE], 3), ([typo, far, PAPER_CASE, bad, PAPER_CASE], 2), ([far, bad], 2),
                            ([typo, far], 2), ([PAPER_CASE] * 16, 0)):
            for quote, path in zip(self.quotes(paths, code=code), paths):
                self.assertEqual(same(quote), same(alone[path]))
        done = ssv("quote", typo, far, PAPER_CASE, bad)
        self.assertEqual(done.stderr.splitlines(), [
            f"ssv: {typo}:15: standof_m: unknown key", f"ssv: {far}: no feasible candidate",
            f"ssv: {bad}: standoff_m: nan is not a finite number"])
        rows = done.stdout.splitlines()
        self.assertEqual([row.split(maxsplit=1)[1] for row in (rows[1], rows[2], rows[4])],
                         ["refused", "no feasible candidate", "refused"])
        self.assertEqual(done.stdout.count("not feasible: "), 3)

    def test_quotes_go_to_the_file_that_is_named(self):
        file = self.folder / "quotes.json"
        done = ssv("quote", PAPER_CASE, "--format", "json", "--output", file)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertEqual(json.loads(file.read_text())["quotes"][0]["status"], "ok")


class ScalarTest(InFolder):
    """The planner in other arithmetics; that their plans are as good is property.scalars' to say."""
    NUMBERS = ("J", "time_s", "impulse_Ns")

    def answer(self, command, path, *arguments):
        done = ssv(command, path, "--format", "json", *arguments)
        self.assertEqual(done.returncode, 0, done)
        return json.loads(done.stdout) if command == "plan" else json.loads(done.stdout)["quotes"][0]

    def too_heavy(self):
        """Costs some 1e8, and the largest number of fixed point is 6.7e7."""
        return self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-300, 0, 0]"), ("{time: 1, impulse: 1}", "{time: 1000, impulse: 1000}"))

    def test_each_scalar_plans_and_quotes_the_scenarios_much_alike_and_none_like_another(self):
        for path in SCENARIOS:
            plans = {scalar: self.answer("plan", path, "--scalar", scalar) for scalar in ("double", "float", "fixed")}
            self.assertEqual(without_stamp(plans["double"]), without_stamp(self.answer("plan", path)))
            self.assertEqual(len({plan["plan_hash"] for plan in plans.values()}), 3)
            for scalar, plan in plans.items():
                with self.subTest(f"{path.stem} {scalar}"):
                    self.assertEqual(self.answer("quote", path, "--scalar", scalar)["cost"], plan["cost"])
                    for key in self.NUMBERS:
                        self.assertAlmostEqual(plan["cost"][key] / plans["double"]["cost"][key], 1, delta=0.01)

    def test_the_programs_of_the_other_scalars_do_the_same_by_themselves_and_say_which_they_are(self):
        for scalar in ("float", "fixed"):
            for name in ("ssv", "ssv-plannerd"):
                version = subprocess.run([BIN / f"{name}-{scalar}", "--version"], capture_output=True, text=True, timeout=60)
                self.assertIn(f"({scalar})", version.stdout)
            itself = subprocess.run([BIN / f"ssv-{scalar}", "plan", PAPER_CASE], capture_output=True, text=True, timeout=60)
            asked = ssv("plan", PAPER_CASE, "--scalar", scalar)
            self.assertEqual((itself.returncode, itself.stdout, itself.stderr), (asked.returncode, asked.stdout, asked.stderr))

    def test_a_number_that_does_not_fit_the_scalar_is_told_and_never_a_price(self):
        path = self.too_heavy()
        self.assertEqual(self.answer("plan", path)["status"], "ok")
        for command, arguments in (("plan", [path]), ("quote", [PAPER_CASE, path])):
            done = ssv(command, *arguments, "--scalar", "fixed")
            self.assertEqual(done.returncode, 5, done)
            self.assertEqual(done.stderr, f"ssv: {path}: a number does not fit the planner's arithmetic, fixed; ask a planner "
                                          "that computes in double\n")
        self.assertEqual(done.stdout.splitlines()[2].split(maxsplit=1)[1], "numeric overflow")
        done = ssv("plan", path, "--scalar", "fixed", "--format", "json")
        self.assertEqual((done.returncode, json.loads(done.stdout)["status"]), (5, "numeric_overflow"))
        self.assertNotIn("cost", json.loads(done.stdout))

    def test_over_lcm_the_planner_must_be_of_the_scalar_asked_for(self):
        over_lcm = [f"--lcm={URL}", "--timeout", "20", "--scalar"]
        with Daemon(URL, "ssv-plannerd-fixed"):
            for command in ("plan", "quote"):
                here = self.answer(command, PAPER_CASE, "--scalar", "fixed")
                self.assertEqual(self.answer(command, PAPER_CASE, *over_lcm, "fixed")["cost"], here["cost"])
                done = ssv(command, PAPER_CASE, *over_lcm, "double")
                self.assertEqual((done.returncode, done.stdout), (4, ""), done)
                self.assertIn("computes in fixed, not in double", done.stderr)
            done = ssv("plan", self.too_heavy(), *over_lcm, "fixed")
            self.assertEqual(done.returncode, 5, done)
            self.assertIn("does not fit", done.stderr)
        done = ssv("plan", PAPER_CASE, f"--lcm={SILENT_URL}", "--scalar", "fixed", "--timeout", "0.2")
        self.assertEqual((done.returncode, done.stdout), (4, ""))
        self.assertIn(SILENT_URL, done.stderr)

    def test_a_program_that_is_not_there_is_named(self):
        alone = self.folder / "ssv"
        alone.write_bytes((BIN / "ssv").read_bytes())
        alone.chmod(0o755)
        done = subprocess.run([alone, "plan", PAPER_CASE, "--scalar", "fixed"], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (1, ""), done)
        self.assertIn(f"{self.folder}/ssv-fixed", done.stderr)


class OutputTest(InFolder):
    def setUp(self):
        super().setUp()
        self.file = self.folder / "plan.json"

    def plan(self, *arguments, path=PAPER_CASE, **options):
        return ssv("plan", path, "--format", "json", "--output", self.file, *arguments, **options)

    def assert_only(self, *names):
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), sorted(names))

    def test_a_plan_goes_to_the_file_and_nothing_to_standard_output(self):
        done = self.plan()
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertEqual(json.loads(self.file.read_text())["status"], "ok")
        self.assert_only("plan.json")

    def test_a_file_that_is_replaced_keeps_its_permissions_and_a_link_stays_a_link(self):
        real = self.folder / "real.json"
        real.write_text("old")
        real.chmod(0o640)
        self.file.symlink_to(real)
        self.assertEqual(self.plan().returncode, 0)
        self.assertTrue(self.file.is_symlink())
        self.assertEqual(real.stat().st_mode & 0o777, 0o640)
        self.assertEqual(json.loads(real.read_text())["status"], "ok")
        self.assert_only("plan.json", "real.json")

    def test_a_failed_write_leaves_the_old_file_whole(self):
        self.file.write_text("old")
        done = self.plan(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("cannot write", done.stderr)
        self.assertEqual(self.file.read_text(), "old")
        self.assert_only("plan.json")

    def test_a_refused_scenario_leaves_no_half_table(self):
        self.file.write_text("old")
        done = ssv("plan", self.scenario(("contact: 1", "contact: 9")), "--output", self.file)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(self.file.read_text(), "old")

    def test_no_answer_and_ctrl_c_leave_the_old_file(self):
        self.file.write_text("old")
        self.assertEqual(self.plan(f"--lcm={SILENT_URL}", "--timeout", "0.2").returncode, 4)
        command = [BIN / "ssv", "plan", PAPER_CASE, "--output", self.file, f"--lcm={SILENT_URL}", "--timeout", "60"]
        process = subprocess.Popen(command)
        listener = lcm.LCM(SILENT_URL)
        listener.subscribe("SSV_SCENARIO", lambda channel, data: None)
        self.assertGreater(listener.handle_timeout(30000), 0)  # it has asked, so it waits
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), -signal.SIGINT)
        self.assertEqual(self.file.read_text(), "old")
        self.assert_only("plan.json")

    def test_what_cannot_be_written_is_named(self):
        self.file = self.folder / "no" / "such" / "plan.json"
        done = self.plan()
        self.assertEqual(done.returncode, 1)
        self.assertIn("no/such/plan.json: No such file or directory", done.stderr)
        self.file = Path("/dev/full")
        done = self.plan()
        self.assertEqual(done.returncode, 1)
        self.assertIn("/dev/full: No space left", done.stderr)
        with open("/dev/full", "w") as full:
            done = subprocess.run([BIN / "ssv", "plan", PAPER_CASE], stdout=full, stderr=subprocess.PIPE, timeout=60)
        self.assertEqual(done.returncode, 1)

    def test_a_device_is_written_to_and_not_replaced(self):
        self.file = Path("/dev/null")
        self.assertEqual(self.plan().returncode, 0)
        self.assertTrue(self.file.is_char_device())


class OverLcmTest(InFolder):
    def ask(self, path, *arguments, url=URL):
        return ssv("plan", path, f"--lcm={url}", "--format", "json", "--timeout", "20", *arguments)

    def test_the_answer_is_the_one_planned_in_process(self):
        with Daemon(URL):
            for path, weights, method in itertools.product(SCENARIOS, ("1,0", "0,1", "1,1"), METHODS):
                with self.subTest(f"{path.stem} {weights} {method}"):
                    arguments = ["--weights", weights, *METHODS[method]]
                    done = self.ask(path, *arguments)
                    self.assertEqual(done.returncode, 0, done)
                    here = json.loads(ssv("plan", path, "--format", "json", *arguments).stdout)
                    there = json.loads(done.stdout)
                    self.assertNotEqual(here["request_id"], there["request_id"])
                    self.assertEqual(without_stamp(here), without_stamp(there))

    def test_invalid_and_infeasible_come_back_with_the_same_reason_and_exit_code(self):
        with Daemon(URL):
            for change in [("standoff_m: 0.3025", "standoff_m: .nan"), ("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]")]:
                path = self.scenario(change)
                here = ssv("plan", path, "--format", "json")
                there = self.ask(path)
                self.assertEqual(there.returncode, here.returncode)
                self.assertEqual(json.loads(there.stdout)["reason"], json.loads(here.stdout)["reason"])
                self.assertEqual(there.stderr, here.stderr)

    def test_quotes_are_those_computed_in_process(self):
        bad = self.folder / "bad.yaml"
        bad.write_text(edited(PAPER_CASE.read_text(), ("standoff_m: 0.3025", "standoff_m: .nan")))
        typo = self.folder / "typo.yaml"
        typo.write_text(edited(PAPER_CASE.read_text(), ("standoff_m", "standof_m")))
        far = self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        stamped = r'"(request_id|epoch_us)": \d+'
        with Daemon(URL):
            for paths, details, code in ((SCENARIOS, [], 0), (SCENARIOS, ["--candidates", "--front"], 0),
                                         ([typo, PAPER_CASE, bad, far, PORT1], [], 2), ([typo], [], 2)):
                for method in METHODS.values():
                    arguments = ["quote", *paths, *details, *method, "--format", "json"]
                    here, there = ssv(*arguments), ssv(*arguments, f"--lcm={URL}", "--timeout", "40")
                    self.assertEqual((here.returncode, there.returncode), (code, code), there)
                    self.assertEqual(re.sub(stamped, "", here.stdout), re.sub(stamped, "", there.stdout))
                    self.assertEqual(here.stderr, there.stderr)
        done = ssv("quote", PAPER_CASE, f"--lcm={SILENT_URL}", "--timeout", "0.2")
        self.assertEqual((done.returncode, done.stdout), (4, ""))
        self.assertIn(SILENT_URL, done.stderr)

    def test_a_planner_that_starts_late_still_answers(self):
        process = subprocess.Popen([BIN / "ssv", "plan", PAPER_CASE, f"--lcm={URL}", "--timeout", "30"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        listener = lcm.LCM(URL)
        listener.subscribe("SSV_SCENARIO", lambda channel, data: None)
        self.assertGreater(listener.handle_timeout(30000), 0)
        with Daemon(URL):
            process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0)

    def test_nobody_there_is_told_with_the_address_and_what_to_do(self):
        start_s = time.monotonic()
        done = ssv("plan", PAPER_CASE, f"--lcm={SILENT_URL}", "--timeout", "0.5")
        self.assertEqual(done.returncode, 4)
        self.assertGreater(time.monotonic() - start_s, 0.5)
        self.assertEqual(done.stdout, "")
        self.assertIn(SILENT_URL, done.stderr)
        self.assertIn("ssv-plannerd", done.stderr)

    def test_the_address_may_follow_the_option_with_or_without_an_equals_sign_wherever_it_stands(self):
        for arguments in ([PAPER_CASE, "--lcm", SILENT_URL], ["--lcm", SILENT_URL, PAPER_CASE]):
            done = ssv("plan", *arguments, "--timeout", "0.2")
            self.assertEqual(done.returncode, 4)
            self.assertIn(SILENT_URL, done.stderr)

    def test_lcm_s_own_default_address_is_used_and_named_without_a_url(self):
        done = ssv("plan", PAPER_CASE, "--lcm", "--timeout", "0.2", env=os.environ | {"LCM_DEFAULT_URL": SILENT_URL})
        self.assertEqual(done.returncode, 4)
        self.assertIn(SILENT_URL, done.stderr)

    def test_an_address_that_is_none_is_told(self):
        done = ssv("plan", PAPER_CASE, "--lcm=nonsense://")
        self.assertEqual(done.returncode, 4)
        self.assertIn("nonsense://", done.stderr)


class HostileAnswerTest(InFolder):
    """Whatever comes on the planner's channels: what is no answer is passed over, and nothing crashes the asker."""

    # Where the request id stands: after the fingerprint and the counts; in a question after the fingerprint and its count.
    KINDS = {"plan": ("SSV_SCENARIO", 8, "SSV_PLAN", 28), "quote": ("SSV_SCENARIO_BATCH", 12, "SSV_QUOTE_BATCH", 12)}

    @classmethod
    def setUpClass(cls):
        cls.good = {}
        for command, (_, _, channel, _) in cls.KINDS.items():
            bus = lcm.LCM(URL)
            bus.subscribe(channel, lambda channel, data: cls.good.setdefault(command, data))
            with Daemon(URL):
                done = ssv(command, PAPER_CASE, f"--lcm={URL}", "--timeout", "20", "--candidates", "--front")
                if done.returncode != 0 or bus.handle_timeout(20000) <= 0:
                    raise AssertionError(done)

    def ask_with_answers(self, command, answers, timeout_s=1):
        """Runs ssv against a stand-in planner that answers every question with all of these, its request id put in."""
        ask_channel, asked_at, answer_channel, answered_at = self.KINDS[command]
        bus = lcm.LCM(URL)
        stop = threading.Event()

        def reply(channel, data):
            for answer in answers:
                answer = bytearray(answer)
                answer[answered_at:answered_at + 8] = data[asked_at:asked_at + 8]
                bus.publish(answer_channel, bytes(answer))

        bus.subscribe(ask_channel, reply)

        def serve():
            while not stop.is_set():
                bus.handle_timeout(50)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            return ssv(command, PAPER_CASE, f"--lcm={URL}", "--timeout", str(timeout_s), "--format", "json")
        finally:
            stop.set()
            thread.join()

    def assert_passed_over(self, command, foreign):
        done = self.ask_with_answers(command, foreign)
        self.assertEqual(done.returncode, 4, done)
        self.assertIn("another version", done.stderr)
        done = self.ask_with_answers(command, foreign[:12] + [self.good[command]])
        self.assertEqual(done.returncode, 0, done)

    def patched(self, command, at, data):
        return self.good[command][:at] + data + self.good[command][at + len(data):]

    def foreign_quotes(self, command, quote_at):
        """Answers with a quote that is none, by where the quote stands."""
        reason_at = quote_at + 33
        return [
            self.patched(command, 0, b"\1" * 8),
            self.patched(command, quote_at, b"\x7f\xff\xff\xff"),  # more candidates than memory
            self.patched(command, quote_at, b"\xff\xff\xff\xff"),  # fewer than no candidates
            self.patched(command, quote_at + 4, b"\0\0\0\x19"),  # one point of a front too many
            self.patched(command, reason_at, b"\0\0\0\0"),  # a reason without even its terminator
            self.patched(command, reason_at, b"\x7f\xff\xff\xff"),  # a reason longer than the message
            self.patched(command, reason_at + 4, b"X"),  # a reason without its terminator
            self.good[command] + b"\0",
            *(self.good[command][:length] for length in range(36, len(self.good[command]), 97)),
        ]

    def test_messages_that_are_no_plan_are_passed_over(self):
        self.assert_passed_over("plan", [
            b"\0" * 36,
            self.patched("plan", 8, b"\x7f\xff\xff\xff"),  # more legs than memory
            self.patched("plan", 12, b"\xff\xff\xff\xff"),  # fewer than no segments
            *self.foreign_quotes("plan", 20),
        ])

    def test_messages_that_are_no_quotes_for_as_many_tasks_as_asked_are_passed_over(self):
        two = self.patched("quote", 8, b"\0\0\0\2") + self.good["quote"][28:]
        self.assert_passed_over("quote", [
            two,
            self.patched("quote", 8, b"\0\0\0\0")[:28],
            self.patched("quote", 8, b"\xff\xff\xff\xff"),
            self.patched("quote", 8, b"\x7f\xff\xff\xff"),
            *self.foreign_quotes("quote", 28),
        ])

    def test_a_damaged_answer_does_not_crash_the_asker(self):
        seed = 20240607
        chance = random.Random(seed)
        for case in range(40):
            command = ("plan", "quote")[case % 2]
            damaged = bytearray(self.good[command])
            for _ in range(chance.choice([1, 4, 64])):
                damaged[chance.randrange(8, len(damaged))] = chance.randrange(256)
            with self.subTest(f"{command}: seed {seed} case {case}"):
                self.assertIn(self.ask_with_answers(command, [damaged], 0.3).returncode, (0, 1, 2, 3, 4))


if __name__ == "__main__":
    unittest.main()
