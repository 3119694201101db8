"""ssv plan and ssv quote from the outside: what users and their scripts rely on."""
import itertools
import json
import math
import os
import random
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
from pathlib import Path

import lcm

BIN = Path(os.environ["SSV_BIN_DIR"])
HOST = Path(os.environ["SSV_SOURCE_DIR"]) / "host"
sys.path.insert(0, str(HOST.parent / "lcmtypes"))
import sample_plan
SCENARIOS = sorted((HOST / "scenarios").glob("*.yaml"))
PAPER_CASE = HOST / "scenarios" / "paper_case.yaml"
PORT1 = HOST / "scenarios" / "port1_contact2.yaml"
CLEAR = sorted((HOST / "scenarios" / "clear").glob("*.yaml"))

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
    del plan["scenario"]["asker"]
    if "plan" in plan:
        del plan["plan"]["answer"]["asker"], plan["plan"]["answer"]["planner"]["planner_id"]
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
        self.assertEqual(list(answer), ["plan"])
        self.assertEqual(answer["plan"]["quote"]["status"], "invalid")
        for word in words:
            self.assertIn(word, answer["plan"]["quote"]["reason"])
        self.assertEqual(done.stderr, f"ssv: {answer['plan']['quote']['reason']}\n")


class BadInputTest(InFolder):
    def test_values_that_make_no_sense_are_refused_by_the_name_of_their_field(self):
        for change, field in [
            (("p_IS_m: [0, 0, 0]", "p_IS_m: [0, .nan, 0]"), ":6:15: vehicle.p_IS_m[1]: nan is not a finite number"),
            (("p_IB_m: [5, 0, 0]", "p_IB_m: [.inf, 0, 0]"), "beam.p_IB_m[0]: inf is not a finite number"),
            (("p_IP_m: [6.524, 5, 0]", "p_IP_m: [6.524, -.inf, 0]"), "port.p_IP_m[1]: -inf is not a finite number"),
            (("p_IP_m: [6.524, 5, 0]", "p_IP_m: [6.524, 5000, 0]"), "port.p_IP_m: 5000 is outside its range"),
            (("standoff_m: 0.3025", "standoff_m: 1e999"), "standoff_m: inf"),
            (("standoff_m: 0.3025", "standoff_m: 0"), "standoff_m: 0 is outside its range"),
            (("q_IS: [0, 0, 0, 1]", "q_IS: [0, 0, 0, 0]"), "vehicle.q_IS: length 0"),
            (("q_IS: [0, 0, 0, 1]", "q_IS: [0, 0, 0, 1.002]"), "vehicle.q_IS: length 1.002"),
            (("q_IB: [0.7071067811865476,", "q_IB: [0.8,"), "beam.q_IB: length"),
            (("axis_I: [0, -1, 0]", "axis_I: [0, -1, 1]"), "port.axis_I: length"),
            (("{time: 1, impulse: 1}", "{time: -1, impulse: 1}"), "weights.time: -1"),
            (("{time: 1, impulse: 1}", "{time: 1, impulse: -0.5}"), "weights.impulse: -0.5"),
            (("{time: 1, impulse: 1}", "{time: 0, impulse: 0}"), "task.yaml:16:17: weights.time: both are zero"),
            (("ring_angle_rad: -1.57", "ring_angle_rad: -7.57"), "ring_angle_rad: -7.57"),
            (("model: paper", "model: paper\nattach_heights_m: [0, 1.6]"), "attach_heights_m[1]: 1.6 is outside its range"),
        ]:
            with self.subTest(field):
                self.assert_refused(self.scenario(change), field)

    def test_a_model_that_makes_no_sense_is_refused_by_the_name_of_its_field(self):
        for change, field in [
            (("mass_kg: 76.2", "mass_kg: 0"), "mine.yaml:6:12: vehicle.mass_kg: 0 is outside its range"),
            (("mass_kg: 11.3636", "mass_kg: -1"), "beam.mass_kg: -1"),
            (("[2.7, 2.7, 2.7]", "[2.7, .nan, 2.7]"), "mine.yaml:7:24: vehicle.inertia_kg_m2[1]: nan"),
            (("length_m: 3.048", "length_m: 0"), "beam.length_m: 0"),
            (("drag_strip_kg_m2: 66.66", "drag_strip_kg_m2: -1"), "beam.drag_strip_kg_m2: -1"),
            (("n_T_S: [1, 0, 0]", "n_T_S: [1, 1, 0]"), "vehicle.thrusters[0].n_T_S: length"),
            (("n_T_S: [0, 1, 0]", "n_T_S: [1, 0, 0]"), "mine.yaml:17:5: vehicle.thrusters: placed so that"),
            (("axis_H: [0.5, 0", "axis_H: [0.6, 0"), "hub.ports[0].axis_H: length"),
            (("p_HP_m: [0.1905", "p_HP_m: [.nan"), "hub.ports[0].p_HP_m[0]: nan"),
        ]:
            with self.subTest(field):
                self.assert_refused(self.scenario_with_model(change), field)

    def test_numbers_that_nothing_can_have_are_refused_with_what_contradicts_them(self):
        impossible = "8.8 is more than the other two together, 0.2, which no body has"
        self.assert_refused(self.scenario_with_model(("[8.816417383965, 8.816417383965, 0.03761834553]", "[0.1, 0.1, 8.8]")),
                            f"mine.yaml:28:18: beam.inertia_kg_m2: {impossible}")
        self.assert_refused(self.scenario_with_model(("[2.7, 2.7, 2.7]", "[0.1, 8.8, 0.1]")),
                            f"mine.yaml:7:18: vehicle.inertia_kg_m2: {impossible}")
        for standoff in ("0.1", "0.3", "0.36"):
            self.assert_refused(self.scenario(("standoff_m: 0.3025", f"standoff_m: {standoff}")),
                                f"task.yaml:15:13: standoff_m: {standoff} is inside hull and beam, whose radii make 0.3631")

    def test_moments_of_inertia_go_from_those_of_struts_to_those_of_booms_in_every_scalar_that_has_digits_for_them(self):
        beam = "[8.816417383965, 8.816417383965, 0.03761834553]"
        for scalar, arguments in (("double", []), ("float", ["--scalar", "float"]), ("fixed", ["--scalar", "fixed"])):
            for moments in ("[1.0e-3, 1.0e-3, 1.5e-6]", "[1.0e-9, 1.0e-9, 1.0e-9]"):
                self.assertEqual(ssv("quote", self.scenario_with_model((beam, moments)), *arguments).returncode, 0, scalar)
            tiny = self.scenario_with_model(("[2.7, 2.7, 2.7]", "[1.0e-9, 1.0e-9, 1.0e-9]"))
            if scalar == "fixed":
                self.assert_refused(tiny, "vehicle.inertia_kg_m2: ", " has too few digits in fixed, which takes 1.53e-05 and more; "
                                    "ask a planner that computes in double", arguments=arguments)
            else:
                self.assertEqual(ssv("quote", tiny, *arguments).returncode, 0, scalar)
        boom = self.scenario_with_model(("force_max_N: 6 ", "force_max_N: 600 "), ("mass_kg: 11.3636", "mass_kg: 5000"),
                                        (beam, "[1.0e+6, 1.0e+6, 100]"))
        for scalar in ("double", "float", "fixed"):
            self.assertEqual(ssv("quote", boom, "--scalar", scalar).returncode, 0, scalar)

    def test_text_where_a_number_belongs_is_refused(self):
        for text in ("1,5", "1.5m", "0x10", "abc", "''", "~", "1e", "--1", "inf"):
            with self.subTest(text):
                change = ("standoff_m: 0.3025", f"standoff_m: {text}")
                self.assert_refused(self.scenario(change), "standoff_m", "is not a number")

    def test_a_word_that_is_no_choice_is_refused_with_the_choices(self):
        self.assert_refused(self.scenario(("contact: 1", "contact: 3")), "beam.contact: '3'", "either, 1, 2")
        self.assert_refused(self.scenario(("port: 1", "port: 4"), base=PORT1), "hub.port: '4' is none of 1, 2, 3")
        for key, word, choices in (("method", "fastest", "optimal, paper"), ("effort", "1", "quick, best"),
                                   ("candidates", "yes", "false, true"), ("front", "1", "false, true"),
                                   ("attach_anywhere", "on", "false, true")):
            path = self.scenario(("model: paper", f"model: paper\n{key}: {word}"))
            self.assert_refused(path, f"{key}: '{word}' is none of {choices}")

    def test_the_hub_is_checked_though_the_planner_never_sees_it(self):
        self.assert_refused(self.scenario(("q_IH: [1, 0, 0, 0]", "q_IH: [0, 0, 0, 0]"), base=PORT1), "hub.q_IH: length 0")
        self.assert_refused(self.scenario(("p_IH_m: [5, 3, 0.5]", "p_IH_m: [5, .inf, 0.5]"), base=PORT1), "hub.p_IH_m[1]: inf")

    def test_an_unknown_a_missing_and_a_repeated_key_are_named_with_their_line(self):
        for change, words in [
            (("standoff_m:", "standof_m:"), ["standof_m: unknown key; did you mean standoff_m?", "task.yaml:15:1: "]),
            (("{time: 1, impulse: 1}", "{time: 1, impulse: 1, fuel: 2}"), ["weights.fuel: unknown key", "task.yaml:16:32: "]),
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
            (("    - {p_ST_m: [0, -0.3025, 0], n_T_S: [0, 0, -1]}\n", ""), ["mine.yaml:", "vehicle.thrusters: 5 entries, there must be exactly 6"]),
            (("n_T_S: [1, 0, 0]", "n_T_S: [1, x, 0]"), ["mine.yaml:", "vehicle.thrusters[0].n_T_S[1]: 'x' is not a number"]),
        ]:
            with self.subTest(words[1]):
                self.assert_refused(self.scenario_with_model(change), *words)

    def test_a_list_of_the_wrong_length_is_refused(self):
        self.assert_refused(self.scenario(("[0, 0, 0, 1]", "[0, 0, 1]")), "vehicle.q_IS: 3 entries, there must be exactly 4")
        self.assert_refused(self.scenario(("[0, 0, 0, 1]", "[0, 0, 0, 1, 0]")), "vehicle.q_IS: 5 entries, there must be exactly 4")
        none, nine = ("model: paper\nattach_heights_m: [" + ", ".join("0" * count) + "]" for count in (0, 9))
        self.assert_refused(self.scenario(("model: paper", none)), "attach_heights_m: 0 entries, there must be 1 to 8")
        self.assert_refused(self.scenario(("model: paper", nine)), "attach_heights_m: 9 entries, there must be 1 to 8")

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
            "huge.yaml": PAPER_CASE.read_bytes() + b"#" * (4 << 20),
        }
        for name, content in contents.items():
            (self.folder / name).write_bytes(content)
        (self.folder / "folder.yaml").mkdir()
        os.mkfifo(self.folder / "fifo.yaml")
        for name in [*contents, "folder.yaml", "fifo.yaml", "absent.yaml"]:
            with self.subTest(name):
                self.assert_refused(self.folder / name, name)

    def test_text_of_the_file_cannot_steer_the_terminal(self):
        done = ssv("plan", self.scenario(("model: paper", 'model: "\\e[31mred\\n"')))
        self.assertEqual(done.returncode, 2)
        self.assertNotIn("\x1b", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        steering = self.folder / "\x1b[31mred\x9b"
        for arguments in (["plan", steering], ["quote", steering], ["plan", PAPER_CASE, "--output", steering / "x"]):
            done = subprocess.run([BIN / "ssv", *arguments], capture_output=True, timeout=60)
            self.assertNotIn(b"\x1b", done.stderr + done.stdout)
            self.assertNotIn(b"\xc2\x9b", done.stderr + done.stdout)

    def test_quaternions_within_a_thousandth_of_unit_length_are_taken(self):
        self.assertEqual(ssv("plan", self.scenario(("[0, 0, 0, 1]", "[0, 0, 0, 1.0009]"))).returncode, 0)

    def test_a_task_that_takes_too_long_is_infeasible_with_a_reason_per_candidate(self):
        path = self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        done = ssv("plan", path, "--format", "json")
        self.assertEqual(done.returncode, 3, done)
        answer = json.loads(done.stdout)
        self.assertEqual(list(answer), ["scenario", "scene", "plan"])
        quote = answer["plan"]["quote"]
        self.assertEqual((quote["status"], quote["cost"], answer["plan"]["legs"]), ("infeasible", 0, []))
        self.assertEqual(len(quote["candidates"]), 3)
        for candidate in quote["candidates"]:
            self.assertIn("longest plan", candidate["reason"])
        done = ssv("plan", path)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stdout.count("not feasible: "), 3)


class ModelTest(InFolder):
    def test_a_forgotten_drag_key_is_refused_and_none_says_that_there_is_no_drag(self):
        drag = "  drag_lin_kg_s: 413.685            # Table 1, C_dv; Table 5 follows the linear law\n"
        self.assert_refused(self.scenario_with_model((drag, "")), "mine.yaml:6:3: vehicle.drag_lin_kg_s: this key is missing; "
                            "give all 4 drag keys (0 is a value), or `drag: none` for a body that feels no water")
        self.assert_refused(self.scenario_with_model(("  drag_strip_kg_m2: 66.66\n", "")),
                            "mine.yaml:26:3: beam.drag_strip_kg_m2: this key is missing; give all 5 drag keys")
        self.assert_refused(self.scenario_with_model((drag, "  drag: none\n")), "vehicle.drag_quad_kg_m: drag: none stands there")
        self.assert_refused(self.scenario_with_model((drag, drag + "  drag: some\n")), "vehicle.drag: only none may stand here")
        text = (HOST / "models" / "ease.yaml").read_text()
        beam = re.search(r"  # Strip theory.*?drag_quad_ang_Nm_s2: 0\n", text, re.S)[0]
        done = ssv("scenario", self.scenario_with_model((beam, "  drag: none\n")), "--format", "json")
        beam = json.loads(done.stdout)["scenario"]["beam"]
        self.assertEqual([value for key, value in (beam | beam["body"]).items() if key.startswith("drag_")], [0.0] * 5)

    def test_added_mass_may_be_left_out_and_is_shown(self):
        self.assertIn("added_mass_kg: [0, 0, 0]", ssv("scenario", PORT1).stdout)
        path = self.scenario_with_model(("mass_kg: 76.2", "added_mass_kg: [1, 2, 3]\n  mass_kg: 76.2"))
        self.assertIn("added_mass_kg: [1, 2, 3]", ssv("scenario", path).stdout)

    def test_no_hub_is_needed_where_the_scenario_gives_the_port(self):
        model = (HOST / "models" / "paper.yaml").read_text()
        (self.folder / "mine.yaml").write_text(model[:model.index("# Table 2")])
        self.assertEqual(ssv("plan", self.scenario(("model: paper", "model: mine.yaml"))).returncode, 0)
        self.assert_refused(self.scenario(("model: ease", "model: mine.yaml"), base=PORT1), "mine.yaml:", "hub: this key is missing")

    def test_a_hub_has_one_to_eight_ports(self):
        model = (HOST / "models" / "ease.yaml").read_text()
        head, ports = model.split("  ports:\n")
        port = ports.splitlines(keepends=True)[0]
        task = PORT1.read_text().replace("model: ease", "model: mine.yaml")
        for count, numbers in ((1, [1]), (8, [1, 8])):
            (self.folder / "mine.yaml").write_text(head + "  ports:\n" + port * count)
            for number in numbers:
                (self.folder / "task.yaml").write_text(task.replace("port: 1", f"port: {number}"))
                with self.subTest(count=count, number=number):
                    expected, mine = (json.loads(ssv("plan", path, "--format", "json").stdout)
                                      for path in (PORT1, self.folder / "task.yaml"))
                    self.assertEqual(mine["plan"]["plan_hash"], expected["plan"]["plan_hash"])
            (self.folder / "task.yaml").write_text(task.replace("port: 1", f"port: {count + 1}"))
            self.assert_refused(self.folder / "task.yaml", f"hub.port: '{count + 1}' is none of 1")
        for count in (0, 9):
            (self.folder / "mine.yaml").write_text(head + ("  ports:\n" + port * count if count else "  ports: []\n"))
            (self.folder / "task.yaml").write_text(task)
            self.assert_refused(self.folder / "task.yaml", "mine.yaml:", f"hub.ports: {count} entries, there must be 1 to 8")

    def test_a_file_that_is_no_model_is_not_repeated(self):
        for content in ("secret: 1\n", "secret\n", "- secret\n", "secret: [\n", "Secret word: {\n", "secret:secret:0\nsecret\n"):
            (self.folder / "mine.yaml").write_text(content)
            done = ssv("plan", self.scenario(("model: paper", "model: mine.yaml")))
            self.assertEqual(done.returncode, 2)
            self.assertIn("mine.yaml:", done.stderr)
            self.assertNotIn("secret", done.stderr.lower())

    def test_planner_s_faults_name_the_file_at_fault_and_the_element(self):
        path = self.scenario_with_model(("n_T_S: [0, -1, 0]", "n_T_S: [0, -1.1, 0]"))
        for command in ("plan", "quote"):
            self.assertEqual(ssv(command, path).stderr, f"ssv: {self.folder}/mine.yaml:20:40: vehicle.thrusters[3].n_T_S: "
                             "length 1.1 is not 1 within 0.001\n")


class QuestionTest(InFolder):
    """What ssv scenario, ssv plan and ssv quote write can be read again."""

    def test_a_question_comes_back_the_same_by_every_way(self):
        for path, method in itertools.product(SCENARIOS, METHODS):
            with self.subTest(f"{path.stem} {method}"):
                first = ssv("plan", path, *METHODS[method], "--format", "json").stdout
                expected = without_stamp(json.loads(first))
                again = {"a plan": first}
                for form in ("yaml", "json"):
                    again[form] = ssv("scenario", path, *METHODS[method], "--format", form).stdout
                    twice = ssv("scenario", "-", "--format", form, input=again[form]).stdout
                    self.assertEqual(twice, again[form])
                for name, text in again.items():
                    done = ssv("plan", "-", "--format", "json", input=text)
                    self.assertEqual(done.returncode, 0, f"{name}: {done}")
                    self.assertEqual(without_stamp(json.loads(done.stdout)), expected)

    def test_a_plan_file_is_a_scenario_by_its_path(self):
        file = self.folder / "plan.json"
        self.assertEqual(ssv("plan", PORT1, "--format", "json", "--output", file).returncode, 0)
        self.assertEqual(ssv("plan", file).stdout.splitlines()[1:], ssv("plan", PORT1).stdout.splitlines()[1:])

    def test_a_message_is_held_to_its_fields(self):
        whole = json.loads(ssv("scenario", PORT1, "--format", "json").stdout)
        for change, words in [
            (lambda s: s.pop("contact"), ["scenario.contact: this key is missing"]),
            (lambda s: s.update(contct=1), ["scenario.contct: unknown key; did you mean contact?"]),
            (lambda s: s["vehicle"]["thruster"][2].update(n_T_S=[1, 2]), ["scenario.vehicle.thruster[2].n_T_S: 2 entries"]),
            (lambda s: s.update(contact=300), ["scenario.contact: 300 is outside [-128, 127]"]),
            (lambda s: s.update(contact=1.5), ["scenario.contact: '1.5' is not a whole number"]),
            (lambda s: s["options"].update(method="fast"), ["scenario.options.method: 'fast' is none of optimal, paper"]),
            (lambda s: s["options"].update(want_front=1), ["scenario.options.want_front: '1' is none of false, true"]),
            (lambda s: s["X_IS"]["p_m"].__setitem__(1, 5000), ["scenario.X_IS.p_m: 5000 is outside its range"]),
        ]:
            with self.subTest(words[0]):
                changed = json.loads(json.dumps(whole))
                change(changed["scenario"])
                path = self.folder / "changed.json"
                path.write_text(json.dumps(changed, indent=1))
                self.assert_refused(path, "changed.json:", *words)


HUB_RADIUS_M, BEAM_RADIUS_M, BEAM_LENGTH_M, HULL_RADIUS_M = 0.1905, 0.0606, 3.048, 0.3025


def to_line(p, obstacle):
    """From a point to the surface of an obstacle; of the tank's walls that of the nearest."""
    away = [a - b for a, b in zip(p, obstacle["p_I_m"])]
    along = sum(a * b for a, b in zip(away, obstacle["axis_I"]))
    if obstacle["kind"] == "wall":
        return along
    along = min(max(along, 0), obstacle["length_m"])
    return math.dist(away, [along * a for a in obstacle["axis_I"]]) - obstacle["radius_m"]


def to_tank(p, tank):
    if tank["kind"] == "none":
        return math.inf
    walls = zip(p, tank["from_I_m"], tank["to_I_m"])
    if tank["kind"] == "box":
        return min(min(x - least, most - x) for x, least, most in walls)
    z, floor, lid = list(walls)[2]
    return min(z - floor, lid - z, tank["radius_m"] - math.dist(p[:2], tank["from_I_m"][:2]))


def nearest_m(answer, step_m=0.01):
    """The least distance along a plan's legs, of points a step apart; the last stretches before mate and dock, where the
    one contact of each is allowed, are left out for that contact alone."""
    scenario, scene, plan = answer["scenario"], answer["scene"], answer["plan"]
    obstacles = [o for k, o in enumerate(scene["obstacles"]) if int(scenario["obstacles"], 16) >> k & 1]
    z_I = sample_plan.rotate(scenario["X_IB"]["q"], [0, 0, 1])
    lying = {"kind": "capsule", "radius_m": BEAM_RADIUS_M, "axis_I": z_I, "length_m": BEAM_LENGTH_M,
             "p_I_m": [p - BEAM_LENGTH_M / 2 * z for p, z in zip(scenario["X_IB"]["p_m"], z_I)]}
    port = scenario["port"]["p_IP_m"]
    of_port = [o for o in obstacles if to_line(port, o) < BEAM_RADIUS_M + scenario["margin_m"]]
    least = math.inf
    for number, leg in enumerate(plan["legs"]):
        carries = leg["phase"] == "transfer"
        is_last = number + 1 == len(plan["legs"]) or plan["legs"][number + 1]["phase"] != leg["phase"]
        leg = types.SimpleNamespace(**leg | {"X_IS_start": types.SimpleNamespace(**leg["X_IS_start"])})
        steps = 2 + int(leg.length * (1 + 3 * math.hypot(*leg.w_S)) / step_m)
        for k in range(steps + 1):
            s = leg.length * k / steps
            p, q = sample_plan.pose_along(leg, s)
            arrives = is_last and leg.length - s <= 0.15
            near = obstacles if carries or arrives else obstacles + [lying]
            least = min([least, to_tank(p, scene["tank"]) - HULL_RADIUS_M] + [to_line(p, o) - HULL_RADIUS_M for o in near])
            for n in range(61 if carries else 0):
                along = (n / 60 - 0.5) * BEAM_LENGTH_M
                p_S = [a + b for a, b in zip(plan["X_SB"]["p_m"], sample_plan.rotate(plan["X_SB"]["q"], [0, 0, along]))]
                at = [a + b for a, b in zip(p, sample_plan.rotate(q, p_S))]
                near = [o for o in obstacles if not (arrives and o in of_port)]
                least = min([least, to_tank(at, scene["tank"]) - BEAM_RADIUS_M] + [to_line(at, o) - BEAM_RADIUS_M for o in near])
    return least


class SceneTest(InFolder):
    """What stands around, in files, in answers and in what is said of both."""

    @classmethod
    def setUpClass(cls):
        cls.plans = {(path.stem, effort): json.loads(ssv("plan", path, "--effort", effort, "--format", "json").stdout)
                     for path in CLEAR for effort in ("quick", "best")}

    def test_every_shipped_scene_has_a_way_that_keeps_3_cm_and_the_answer_says_where_it_is_nearest(self):
        self.assertEqual([path.name for path in CLEAR], [path.name for path in SCENARIOS])
        for (name, effort), answer in self.plans.items():
            with self.subTest(f"{name} {effort}"):
                plan = answer["plan"]
                self.assertEqual((plan["quote"]["status"], plan["quote"]["reason"]), ("ok", ""))
                self.assertEqual(shape(answer["scene"]["tank"]), SCENE_SHAPE["tank"])
                self.assertEqual(shape(answer["scene"]["obstacles"]),
                                 ["any", OBSTACLE_SHAPE] if answer["scene"]["obstacles"] else [])
                self.assertEqual(shape(plan), PLAN_SHAPE)
                clearance = plan["clearance"]
                self.assertGreaterEqual(clearance["certified_m"], 0.03)
                self.assertTrue(0 <= clearance["seen_m"] - clearance["certified_m"] <= 0.005)
                self.assertTrue(0 <= clearance["s"] <= plan["legs"][clearance["leg"]]["length"])
                least = nearest_m(answer)
                self.assertGreaterEqual(least, clearance["certified_m"] - 1e-9)
                self.assertLess(least, clearance["seen_m"] + 0.006)  # samples are a centimetre apart, and may miss the nearest
                table = ssv("plan", HOST / "scenarios" / "clear" / f"{name}.yaml", "--effort", effort).stdout
                what = {64: "its beam", 65: "the tank's wall"}.get(clearance["obstacle"], f"obstacle {clearance['obstacle']}")
                self.assertIn(f"Keeps clear by {1000 * clearance['certified_m']:.0f} mm ({what}, the {clearance['body']} on leg "
                              f"{clearance['leg'] + 1} of {plan['num_legs']})\n", table)
                self.assertLessEqual(max(map(len, table.splitlines())), 120)
        for path in SCENARIOS:
            self.assertNotIn("clear", ssv("plan", path).stdout)

    def test_every_scalar_finds_a_way_through_every_shipped_scene(self):
        for scalar in ("float", "fixed"):
            done = ssv("quote", *CLEAR, "--scalar", scalar, "--format", "json")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for row in json.loads(done.stdout)["quotes"]:
                here = self.plans[Path(row["file"]).stem, "quick"]["plan"]["quote"]["cost"]
                self.assertLess(abs(row["quote"]["cost"] / here - 1), 0.05)  # a search may end in another way

    def test_the_last_stretch_before_mate_and_dock_is_straight_and_slow_where_a_cap_says_so(self):
        for (name, effort), answer in self.plans.items():
            with self.subTest(f"{name} {effort}"):
                scenario, legs = answer["scenario"], answer["plan"]["legs"]
                last = {leg["phase"]: leg for leg in legs}
                for phase, leg in last.items():
                    self.assertEqual(leg["kind"], "translate", phase)
                    self.assertGreaterEqual(leg["length"], 0.15 - 1e-9)
                self.assertLess(math.dist(last["transit"]["v_S"], [1, 0, 0]), 1e-9)  # the contact is on +x
                v_I = sample_plan.rotate(last["transfer"]["X_IS_start"]["q"], last["transfer"]["v_S"])
                self.assertLess(math.dist(v_I, [-a for a in scenario["port"]["axis_I"]]), 1e-6)
                for leg in legs:
                    for cap, speed in ((scenario[leg["phase"] + "_speed_max_m_s"], math.hypot(*leg["v_S"])),
                                       (scenario[leg["phase"] + "_rate_max_rad_s"], math.hypot(*leg["w_S"]))):
                        self.assertTrue(cap == 0 or leg["peak_speed"] * speed <= cap * (1 + 1e-9))
                for leg in last.values():
                    cap = scenario["contact_speed_max_m_s"]
                    self.assertTrue(cap == 0 or leg["peak_speed"] <= cap * (1 + 1e-9))
                self.assertEqual(scenario["contact_speed_max_m_s"] > 0, name == "port1_contact2")

    def test_a_task_with_a_scene_comes_back_the_same_by_every_way(self):
        for path in CLEAR:
            with self.subTest(path.stem):
                expected = without_stamp(self.plans[path.stem, "quick"])
                ways = [ssv("plan", path, "--format", "json").stdout, ssv("scenario", path).stdout,
                        ssv("scenario", path, "--format", "json").stdout]
                for text in ways:
                    done = ssv("plan", "-", "--format", "json", input=text)
                    self.assertEqual(done.returncode, 0, done)
                    self.assertEqual(without_stamp(json.loads(done.stdout)), expected)

    def test_a_scene_is_written_by_hand_in_another_file_or_follows_from_the_hub(self):
        avoid = self.scenario(("port: 1\n", "port: 1\navoid: {hub: true, built: [3, 2]}\n"), base=PORT1)
        scene = json.loads(ssv("scenario", avoid, "--format", "json").stdout)["scene"]
        half = math.sqrt(0.75)
        axes = [[0, 0, 0], [-0.25, -half / 2, half], [-0.25, half / 2, half]]
        for obstacle, axis in zip(scene["obstacles"], axes):
            is_hub = axis == [0, 0, 0]
            self.assertEqual((obstacle["kind"], obstacle["radius_m"], obstacle["length_m"]),
                             ("capsule", HUB_RADIUS_M, 0) if is_hub else ("capsule", BEAM_RADIUS_M, BEAM_LENGTH_M))
            self.assertLess(math.dist(obstacle["axis_I"], axis), 1e-12)
            self.assertLess(math.dist(obstacle["p_I_m"], [p + 0.381 * a for p, a in zip([5, 3, 0.5], axis)]), 1e-12)
        self.assertEqual(scene["num_obstacles"], 3)

        by_hand = ("obstacles:\n  - sphere: {p_I_m: [1, 2, 3], radius_m: 0.5}\n  - capsule: {p_I_m: [0, 0, 0], to_I_m: [0, 3, 4], "
                   "radius_m: 0.1}\n  - capsule: {p_I_m: [0, 0, 0], axis_I: [0, 0.6, 0.8], length_m: 5, radius_m: 0.1}\n"
                   "  - wall: {p_I_m: [0, 0, -9], axis_I: [0, 0, 1.0004]}\n"
                   "tank: {cylinder: {p_I_m: [1, 2, -9], height_m: 12, radius_m: 8}}\n")
        (self.folder / "pool.yaml").write_text(by_hand)
        inside = "scene:\n" + "".join(f"  {line}\n" for line in by_hand.splitlines())
        shown = []
        for text in ("scene: pool.yaml\n", inside):
            path = self.scenario(("weights:", text + "left: [2, 0]\nweights:"), base=PORT1)
            shown.append(json.loads(ssv("scenario", path, "--format", "json").stdout))
        self.assertEqual(shown[0], shown[1])
        scenario, scene = shown[0]["scenario"], shown[0]["scene"]
        self.assertEqual((scenario["obstacles"], scenario["left"]), ("000000000000000f", "0000000000000005"))
        sphere, tube, same, wall = scene["obstacles"]
        self.assertEqual(sphere, {"kind": "capsule", "p_I_m": [1, 2, 3], "axis_I": [0, 0, 0], "length_m": 0, "radius_m": 0.5})
        self.assertEqual(wall, {"kind": "wall", "p_I_m": [0, 0, -9], "axis_I": [0, 0, 1], "length_m": 0, "radius_m": 0})
        self.assertLess(math.dist(tube["axis_I"] + [tube["length_m"]], same["axis_I"] + [5]), 1e-12)
        self.assertEqual(scene["tank"], {"kind": "cylinder", "from_I_m": [1, 2, -9], "to_I_m": [1, 2, 3], "radius_m": 8})
        both = self.scenario(("weights:", "scene: pool.yaml\navoid: {hub: true}\nweights:"), base=PORT1)
        obstacles = json.loads(ssv("scenario", both, "--format", "json").stdout)["scene"]["obstacles"]
        self.assertEqual((len(obstacles), obstacles[:4], obstacles[4]["radius_m"]), (5, scene["obstacles"], HUB_RADIUS_M))

    def test_each_wrong_scene_is_refused_by_file_line_and_key(self):
        def listed(obstacle):
            return f"scene:\n  obstacles:\n    - {obstacle}\n"
        many = "scene: {obstacles: [" + ", ".join(["wall: {p_I_m: [0, 0, -99], axis_I: [0, 0, 1]}"] * 65) + "]}\n"
        most = many.replace("wall: {p_I_m: [0, 0, -99], axis_I: [0, 0, 1]}, ", "", 1)
        at = "task.yaml:15:"
        for text, words in [
            (many.replace("wall", "{wall").replace("]}, ", "]}}, ").replace("1]}]", "1]}}]"), [at, "scene.obstacles: 65 entries, there may be 64 at most"]),
            (most.replace("wall", "{wall").replace("]}, ", "]}}, ").replace("1]}]", "1]}}]") + "avoid: {hub: true}\n",
             ["task.yaml:16:", "avoid: makes 65 obstacles, there may be 64 at most"]),
            (listed("sphere: {p_I_m: [0, 0, 9], radius_m: -1}"), ["task.yaml:17:44: scene.obstacles[0].sphere.radius_m: -1 is outside its range [0, 100]"]),
            (listed("sphere: {p_I_m: [0, 0, .nan], radius_m: 1}"), ["task.yaml:17:30: scene.obstacles[0].sphere.p_I_m[2]: nan is not a finite number"]),
            (listed("sphere: {p_I_m: [0, 0, 2000], radius_m: 1}"), ["scene.obstacles[0].sphere.p_I_m: 2000 is outside its range"]),
            (listed("sphere: {p_I_m: [0, 0], radius_m: 1}"), ["scene.obstacles[0].sphere.p_I_m: 2 entries, there must be exactly 3"]),
            (listed("sphere: {p_I_m: [0, 0, 0]}"), ["scene.obstacles[0].sphere.radius_m: this key is missing"]),
            (listed("sphere: {p_I_m: [0, 0, 0], radius_m: big}"), ["scene.obstacles[0].sphere.radius_m: 'big' is not a number"]),
            (listed("sphere: {p_I_m: [0, 0, 0], radius_m: 1, axis_I: [1, 0, 0]}"), ["scene.obstacles[0].sphere.axis_I: unknown key"]),
            (listed("ball: {p_I_m: [0, 0, 0], radius_m: 1}"), ["task.yaml:17:7: scene.obstacles[0].ball: unknown key"]),
            (listed("walls: {p_I_m: [0, 0, 0], axis_I: [0, 0, 1]}"), ["unknown key; did you mean wall?"]),
            (listed("[1, 2]"), ["scene.obstacles[0]: not one of sphere: {...}, capsule: {...}, wall: {...}"]),
            (listed("wall: {p_I_m: [0, 0, 0], axis_I: [0, 0, 1.1]}"), ["scene.obstacles[0].wall.axis_I: length 1.1 is not 1 within 0.001"]),
            (listed("capsule: {p_I_m: [0, 0, 0], axis_I: [0, 0, 1], radius_m: 1}"), ["scene.obstacles[0].capsule.length_m: this key is missing"]),
            (listed("capsule: {p_I_m: [0, 0, 0], to_I_m: [0, 0, 1], length_m: 1, radius_m: 1}"), ["capsule.to_I_m: axis_I or length_m is given too"]),
            (listed("capsule: {p_I_m: [0, 0, 0], to_I_m: [0, 0, .inf], radius_m: 1}"), ["capsule.to_I_m[2]: inf is not a finite number"]),
            (listed("capsule: {p_I_m: [0, 0, 0], axis_I: [0, 0, 1], length_m: -1, radius_m: 1}"), ["scene.obstacles[0].capsule: -1 is outside its range [0, 1000]"]),
            ("scene: {obstacles: {}}\n", ["scene.obstacles: not a list of obstacles"]),
            ("scene: {obstacle: []}\n", ["scene.obstacle: unknown key; did you mean obstacles?"]),
            ("scene: [1]\n", ["scene: neither a map {obstacles, tank} nor a path"]),
            ("scene: no/such.yaml\n", ["no/such.yaml: cannot open"]),
            ("scene: {tank: {box: {from_I_m: [-9, -9, -9], to_I_m: [9, -10, 9]}}}\n", ["scene.tank.box.to_I_m: -10 is outside its range [-9, 1000]"]),
            ("scene: {tank: {box: {from_I_m: [-9, -9, -9]}}}\n", ["scene.tank.box.to_I_m: this key is missing"]),
            ("scene: {tank: {cylinder: {p_I_m: [0, 0, 0], height_m: 5, radius_m: 0}}}\n", ["scene.tank.cylinder.radius_m: 0 is outside its range"]),
            ("scene: {tank: {cylinder: {p_I_m: [0, 0, 0], height_m: -5, radius_m: 1}}}\n", ["scene.tank.cylinder.height_m: -5 is outside its range [0, 1000]"]),
            ("scene: {tank: {round: {}}}\n", ["scene.tank.round: unknown key"]),
            ("margin_m: -0.1\n", ["task.yaml:15:1", "margin_m: -0.1 is outside its range [0, 10]"]),
            ("margin_m: .nan\n", ["margin_m: nan is not a finite number"]),
            ("aproach_mate_m: 1\n", ["aproach_mate_m: unknown key; did you mean approach_mate_m?"]),
            ("transit_speed_max_m_s: fast\n", ["transit_speed_max_m_s: 'fast' is not a number"]),
            ("avoid: {hub: 1}\n", ["avoid.hub: neither true nor false"]),
            ("avoid: {built: [1]}\n", ["avoid.built[0]: port 1 is the one that the beam is to dock at"]),
            ("avoid: {built: [2, 2]}\n", ["avoid.built[1]: port 2 is named twice"]),
            ("avoid: {built: [4]}\n", ["avoid.built[0]: '4' is none of 1, 2, 3"]),
            ("avoid: {built: 2}\n", ["avoid.built: not a list of ports"]),
            ("avoid: {hubs: true}\n", ["avoid.hubs: unknown key; did you mean hub?"]),
            ("left: [0]\n", ["left[0]: '0' is no number of an obstacle; there are 0"]),
            ("left: 0\n", ["left: not a list of obstacles' numbers"]),
        ]:
            with self.subTest(words[-1]):
                self.assert_refused(self.scenario(("weights:", text + "weights:"), base=PORT1), *words)
        self.assert_refused(self.scenario(("weights:", "avoid: {hub: true}\nweights:")), "avoid: hub is missing")
        model = (HOST / "models" / "ease.yaml").read_text()
        (self.folder / "mine.yaml").write_text(re.sub("  radius_m: 0.1905.*\n", "", model))
        self.assert_refused(self.scenario(("model: ease", "model: mine.yaml\navoid: {hub: true}"), base=PORT1),
                            "avoid.hub: the model's hub has no radius_m")
        (self.folder / "pool.yaml").write_text("obstacles:\n  - sphere: {p_I_m: [0, 0, 9], radius_m: -1}\n")
        self.assert_refused(self.scenario(("weights:", "scene: pool.yaml\nweights:"), base=PORT1),
                            "pool.yaml:2:42: obstacles[0].sphere.radius_m: -1 is outside its range [0, 100]")

    def test_a_message_s_scene_is_held_to_its_fields_and_its_choice(self):
        whole = json.loads(ssv("scenario", CLEAR[0], "--format", "json").stdout)
        for change, words in [
            (lambda w: w["scenario"].update(obstacles="0000000000000009"), ["scenario.obstacles: bit 3 is set, but the scene has 3 obstacles"]),
            (lambda w: w.pop("scene"), ["scenario.obstacles: bit 0 is set, but the scene has 0 obstacles"]),
            (lambda w: w["scenario"].update(obstacles=7), ["scenario.obstacles: not a text of 16 hex digits"]),
            (lambda w: w["scene"].update(num_obstacles=4), ["scene.obstacles: 3 entries, there must be exactly 4"]),
            (lambda w: w["scene"].update(num_obstacles=65), ["scene.obstacles: 65 entries are counted, there may be 0 to 64"]),
            (lambda w: w["scene"]["obstacles"][1].update(kind="cube"), ["scene.obstacles[1].kind: 'cube' is none of capsule, wall"]),
            (lambda w: w["scene"]["obstacles"][1].update(axis_I=[0, 0, 1.001]), ["scene.obstacles[1].axis_I: length 1.001 is not 1 within 1e-05"]),
            (lambda w: w["scene"]["tank"].pop("radius_m"), ["scene.tank.radius_m: this key is missing"]),
        ]:
            with self.subTest(words[0]):
                changed = json.loads(json.dumps(whole))
                change(changed)
                path = self.folder / "changed.json"
                path.write_text(json.dumps(changed, indent=1))
                self.assert_refused(path, "changed.json:", *words)

    def test_an_end_that_is_blocked_is_infeasible_and_says_which_body_is_how_deep_in_what(self):
        for obstacle, reason, (body, number, clearance_m) in [
            ("sphere: {p_I_m: [-0.4, 0, 0], radius_m: 0.2}", "the vehicle starts 102 mm inside obstacle 0", ("vehicle", 0, -0.1025)),
            ("sphere: {p_I_m: [-0.52, 0, 0], radius_m: 0.2}", "the vehicle starts 18 mm from obstacle 0, 12 mm too near", ("vehicle", 0, 0.0175)),
            ("sphere: {p_I_m: [5, 0.15, 0], radius_m: 0.1}", "the beam starts 11 mm inside obstacle 0", ("beam", 0, -0.0106)),
            ("sphere: {p_I_m: [6.524, 3, 0.2], radius_m: 0.2}", "no room to dock: the beam is 61 mm inside obstacle 0", ("beam", 0, -0.0606)),
            ("wall: {p_I_m: [0, -0.3, 0], axis_I: [0, 1, 0]}", "the vehicle starts 2.5 mm inside obstacle 0", ("vehicle", 0, -0.0025)),
        ]:
            with self.subTest(reason):
                text = f"margin_m: 0.03\nscene:\n  obstacles:\n    - {obstacle}\nweights:"
                path = self.scenario(("weights:", text))
                done = ssv("plan", path, "--format", "json")
                self.assertEqual(done.returncode, 3, done)
                answer = json.loads(done.stdout)["plan"]
                self.assertEqual(answer["quote"]["reason"], f"no feasible candidate; each: {reason}")
                self.assertEqual(answer["clearance"]["obstacle"], -1)
                for candidate in answer["quote"]["candidates"]:
                    self.assertEqual((candidate["reason"], candidate["body"], candidate["obstacle"]), (reason, body, number))
                    self.assertAlmostEqual(candidate["clearance_m"], clearance_m, 9)
                for command in ("plan", "quote"):
                    done = ssv(command, path, "--candidates")
                    self.assertEqual((done.returncode, done.stdout.count(f"not feasible: {reason}\n")), (3, 3), done)
                    self.assertLessEqual(max(map(len, done.stdout.splitlines())), 120)

    def test_where_no_way_is_found_the_tank_and_the_beam_are_named_too(self):
        tank = "margin_m: 0.03\nscene:\n  tank: {box: {from_I_m: [-0.32, -9, -9], to_I_m: [20, 9, 9]}}\nweights:"
        done = ssv("plan", self.scenario(("weights:", tank)), "--format", "json")
        self.assertEqual(json.loads(done.stdout)["plan"]["quote"]["reason"],
                         "no feasible candidate; each: the vehicle starts 18 mm from the tank's wall, 12 mm too near")
        # Between two walls the vehicle cannot come to the beam, which lies beyond a gap that is too narrow.
        gap = "".join(f"    - capsule: {{p_I_m: [2.5, {y}, -20], to_I_m: [2.5, {y}, 20], radius_m: 0.5}}\n"
                      for y in [round(0.7 + 1.4 * k, 1) for k in range(-15, 15)])
        done = ssv("plan", self.scenario(("weights:", f"margin_m: 0.03\nscene:\n  obstacles:\n{gap}weights:")), "--format", "json")
        self.assertEqual(done.returncode, 3, done)
        for candidate in json.loads(done.stdout)["plan"]["quote"]["candidates"]:
            self.assertRegex(candidate["reason"], r"^no way: the (vehicle|beam) comes (\S+ m?m inside|within \S+ m?m of) "
                             r"(obstacle \d+|its beam)(, \S+ mm too near)?$")
            self.assertLess(candidate["clearance_m"], 0.0302)

    def test_over_lcm_scenes_get_the_answers_that_they_get_in_process(self):
        with Daemon(URL):
            for path in CLEAR:
                there = json.loads(ssv("plan", path, f"--lcm={URL}", "--timeout", "30", "--format", "json").stdout)
                expected = without_stamp(self.plans[path.stem, "quick"])
                there["plan"]["answer"]["planner"]["planner_id"] = None
                self.assertEqual(without_stamp(there), expected)
            mixed = [*CLEAR, *SCENARIOS, *CLEAR]  # batches have one scene each
            here, there = (json.loads(ssv("quote", *mixed, *lcm_option, "--format", "json").stdout)["quotes"]
                           for lcm_option in ([], [f"--lcm={URL}", "--timeout", "30"]))
            self.assertEqual([row["quote"] for row in there], [row["quote"] for row in here])


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
            ["quote", PAPER_CASE, "--front=all"],
        ]:
            with self.subTest(arguments):
                done = ssv(*arguments)
                self.assertEqual(done.returncode, 64, done)
                self.assertEqual(done.stdout, "")
                self.assertIn("ssv", done.stderr)

    def test_help_has_examples_and_every_exit_code(self):
        every = ["0", "1", "2", "3", "4", "5", "64"]
        for command, expected in (("plan", every), ("quote", every), ("scenario", ["0", "1", "2", "64"]), ("schedule", ["0", "1", "2", "3", "4", "64"]),
                                  ("fly", sorted([*every, "6", "7", "8"])), ("report", ["0", "1", "2", "64"]), ("plot", ["0", "1", "2", "64"]),
                                  ("log", ["0", "1", "2", "64"]), ("watch", ["0", "1", "4", "64"])):
            done = ssv(command, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("Examples:", done.stdout)
            lines = [line for line in re.split("Exit codes.*:", done.stdout)[1].splitlines() if line.strip()]
            self.assertEqual([line for line in lines if not re.match("  ( [0-9]|[0-9]{2}|  )  ", line)], []) # none was wrapped
            codes = [line.split()[0] for line in lines]
            self.assertEqual(sorted(code for code in codes if code.isdigit()), expected)
            self.assertLessEqual(max(map(len, done.stdout.splitlines())), 80)
            self.assertIn(f"  {command} ", ssv("--help").stdout)

    def test_version_is_that_of_the_daemon(self):
        daemon = subprocess.run([BIN / "ssv-plannerd", "--version"], capture_output=True, text=True, timeout=60)
        self.assertEqual(ssv("--version").stdout.split()[1:], daemon.stdout.split()[1:])

    def test_weights_of_the_command_line_count_over_those_of_the_file(self):
        plan = json.loads(ssv("plan", PAPER_CASE, "--weights", "0.5,2e-1", "--format", "json").stdout)
        scenario, quote = plan["scenario"], plan["plan"]["quote"]
        self.assertEqual((scenario["weight_time_per_s"], scenario["weight_impulse_per_Ns"]), (0.5, 0.2))
        self.assertAlmostEqual(quote["cost"], 0.5 * quote["time_s"] + 0.2 * quote["impulse_Ns"], 9)
        done = ssv("plan", PAPER_CASE, "--weights", "-1,0")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, "ssv: --weights: weight_time_per_s: -1 is outside its range [0, 1000]\n")

    def test_method_and_effort_come_from_the_command_line_else_from_the_file_else_from_the_defaults_in_the_help(self):
        def used(path, *arguments):
            scenario = json.loads(ssv("plan", path, "--format", "json", *arguments).stdout)["scenario"]
            return scenario["options"]["method"], scenario["options"]["effort"]

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
        done = ssv("plan", "-", "--format", "json", input=PAPER_CASE.read_text())
        self.assertEqual(done.returncode, 0, done)
        done = ssv("quote", "-", PORT1, input=PAPER_CASE.read_text())
        self.assertEqual((done.returncode, done.stdout.count("\n")), (0, 3), done)
        done = ssv("plan", "-", input="model: [")
        self.assertEqual(done.returncode, 2)
        self.assertIn("ssv: standard input:2:1: not YAML", done.stderr)

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
POSE = {"p_m": V3, "q": Q4}
BODY = {"mass_kg": "real", "inertia_kg_m2": V3, "added_mass_kg": V3, "drag_lin_kg_s": "real", "drag_quad_kg_m": "real",
        "drag_lin_ang_Nm_s": "real", "drag_quad_ang_Nm_s2": "real"}
ASKER = {"asker_id": "text", "request_id": "text", "epoch_us": "integer", "planner_id": "text"}
ANSWER = {"asker": ASKER, "question_hash": "text", "planner": {"planner_id": "text", "version": "text", "scalar": "text"}}
SCENARIO_SHAPE = {
    "asker": ASKER,
    "vehicle": {"body": BODY, "radius_m": "real", "force_max_N": "real", "thruster": ["any", {"p_ST_m": V3, "n_T_S": V3}]},
    "beam": {"body": BODY, "radius_m": "real", "length_m": "real", "drag_strip_kg_m2": "real"},
    "X_IS": POSE, "X_IB": POSE, "port": {"p_IP_m": V3, "axis_I": V3}, "contact": "integer", "standoff_m": "real",
    "weight_time_per_s": "real", "weight_impulse_per_Ns": "real",
    "thrust_reserve": "real",
    "options": {"method": "text", "effort": "text", "num_attach_heights": "integer", "attach_heights_m": [8, "real"],
                "attach_anywhere": "flag", "ring_angle_given": "flag", "ring_angle_rad": "real", "want_candidates": "flag",
                "want_front": "flag"},
    "obstacles": "text", "left": "text", "margin_m": "real", "approach_mate_m": "real", "approach_dock_m": "real",
    "contact_speed_max_m_s": "real", "transit_speed_max_m_s": "real", "transit_rate_max_rad_s": "real",
    "transfer_speed_max_m_s": "real", "transfer_beam_speed_max_m_s": "real", "transfer_rate_max_rad_s": "real",
}
OBSTACLE_SHAPE = {"kind": "text", "p_I_m": V3, "axis_I": V3, "length_m": "real", "radius_m": "real"}
SCENE_SHAPE = {"num_obstacles": "integer", "obstacles": [],
               "tank": {"kind": "text", "from_I_m": V3, "to_I_m": V3, "radius_m": "real"}}
QUOTE_SHAPE = {
    "num_candidates": "integer", "num_front": "integer",
    "scenario_hash": "text", "status": "text", "reason": "text", "cost": "real", "cost_lower_bound": "real", "time_s": "real",
    "impulse_Ns": "real",
    "choice": {"contact": "integer", "attach_height_m": "real", "ring_angle_rad": "real", "candidates": "integer"},
    "X_IS_final": POSE, "X_IB_final": POSE, "candidates": [], "front": [],
}
PLAN_SHAPE = {
    "answer": ANSWER, "num_legs": "integer", "num_arcs": "integer", "num_segments": "integer", "num_events": "integer", "quote": QUOTE_SHAPE, "plan_hash": "text",
    "legs": ["any", {"phase": "text", "kind": "text", "ramp": "text", "t_start_s": "real", "duration_s": "real",
                     "impulse_Ns": "real", "length": "real", "peak_speed": "real", "v_S": V3, "w_S": V3, "X_IS_start": POSE,
                     "X_IS_end": POSE, "first_arc": "integer", "num_arcs": "integer"}],
    "arcs": ["any", {"t_s": "real", "duration_s": "real", "s": "real", "v_start": "real", "v_end": "real", "dv_dt": V3}],
    "segments": ["any", {"t_s": "real", "duration_s": "real", "u_start_N": U6, "u_end_N": U6, "leg": "integer"}],
    "events": ["any", {"t_s": "real", "kind": "text"}],
    "X_SB": POSE,
    "clearance": {"certified_m": "real", "seen_m": "real", "leg": "integer", "s": "real", "body": "text", "obstacle": "integer"},
    "arrival": {"rounding_m": "real", "rounding_rad": "real", "lines_m": "real", "lines_rad": "real"},
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
                self.assertEqual(shape(plan), {"scenario": SCENARIO_SHAPE, "scene": SCENE_SHAPE, "plan": PLAN_SHAPE})
                self.assertEqual(list(plan["plan"]), list(PLAN_SHAPE))
                self.assertEqual(list(plan["scenario"]), list(SCENARIO_SHAPE))
                options = plan["scenario"]["options"]
                self.assertEqual(options["ring_angle_given"], name == "paper_case")
                self.assertEqual(options["num_attach_heights"], 3 if name == "port2_either" else 0)

    def test_the_parts_of_a_plan_agree_with_one_another(self):
        for task, answer in self.plans.items():
            with self.subTest(" ".join(task)):
                scenario, plan = answer["scenario"], answer["plan"]
                quote, legs = plan["quote"], plan["legs"]
                self.assertEqual((quote["status"], quote["reason"]), ("ok", ""))
                self.assertEqual(plan["answer"]["asker"], scenario["asker"])
                self.assertEqual([event["kind"] for event in plan["events"]], ["mate", "dock"])
                for total, of_leg in (("time_s", "duration_s"), ("impulse_Ns", "impulse_Ns")):
                    self.assertTrue(math.isclose(sum(leg[of_leg] for leg in legs), quote[total], rel_tol=1e-12), total)
                self.assertTrue(0 <= quote["cost_lower_bound"] <= quote["cost"])
                transit_s = sum(leg["duration_s"] for leg in legs if leg["phase"] == "transit")
                self.assertAlmostEqual(plan["events"][0]["t_s"], transit_s, 9)
                self.assertAlmostEqual(plan["events"][1]["t_s"], quote["time_s"], 9)
                self.assertEqual(legs[-1]["X_IS_end"], quote["X_IS_final"])
                for name in ("legs", "arcs", "segments", "events"):
                    self.assertEqual(plan[f"num_{name}"], len(plan[name]))
                for text in (quote["scenario_hash"], plan["plan_hash"]):
                    self.assertRegex(text, "^[0-9a-f]{16}$")

    def test_the_scenarios_cover_every_port_every_contact_and_a_tie(self):
        texts = {path.stem: path.read_text() for path in SCENARIOS}
        for choice in ("port: 1", "port: 2", "port: 3", "contact: 1", "contact: 2", "contact: either"):
            self.assertTrue(any(f"  {choice}\n" in text for text in texts.values()), choice)
        self.assertGreaterEqual(self.plans["on_axis", "paper"]["plan"]["quote"]["choice"]["candidates"], 2 * 3 * 16)

    def test_method_optimal_costs_no_more_than_paper(self):
        for path in SCENARIOS:
            with self.subTest(path.stem):
                paper, quick, best = (self.plans[path.stem, method]["plan"]["quote"]["cost"] for method in METHODS)
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
                w, x, y, z = plan["plan"]["quote"]["X_IB_final"]["q"]
                z_B = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
                outward = -1 if plan["plan"]["quote"]["choice"]["contact"] == 1 else 1
                half_m = plan["scenario"]["beam"]["length_m"] / 2
                for i in range(3):
                    contact = plan["plan"]["quote"]["X_IB_final"]["p_m"][i] + outward * half_m * z_B[i]
                    self.assertAlmostEqual(contact, plan["scenario"]["port"]["p_IP_m"][i], 9)
                    self.assertAlmostEqual(outward * z_B[i], -plan["scenario"]["port"]["axis_I"][i], 9)

    def test_numbers_survive_the_file_bit_for_bit(self):
        self.assertEqual(self.plans["paper_case", "paper"]["scenario"]["options"]["ring_angle_rad"], -1.5707963267948966)
        self.assertEqual(self.plans["paper_case", "paper"]["scenario"]["X_IB"]["q"][0], 0.7071067811865476)

    def test_the_table_shows_the_same_plan(self):
        for (name, method), plan in self.plans.items():
            with self.subTest(f"{name} {method}"):
                table = ssv("plan", HOST / "scenarios" / f"{name}.yaml", *METHODS[method]).stdout
                self.assertIn(f"= {plan['plan']['quote']['cost']:.3f}\n", table)
                self.assertIn(plan["plan"]["plan_hash"], table)
                self.assertLessEqual(max(map(len, table.splitlines())), 120)

    def test_the_table_tells_the_lower_bound_and_how_far_off_the_plan_can_be(self):
        for (name, method), plan in self.plans.items():
            with self.subTest(f"{name} {method}"):
                table = ssv("plan", HOST / "scenarios" / f"{name}.yaml", *METHODS[method]).stdout
                cost, least = plan["plan"]["quote"]["cost"], plan["plan"]["quote"]["cost_lower_bound"]
                self.assertIn(f"No plan of any kind costs less than {least:.3f}", table)
                gap = 100 * (cost / least - 1)
                self.assertIn(f": this one is at most {gap:.1f} % above the best possible" if gap <= 100 else ", a weak bound: ", table)

    def test_a_bound_that_says_nothing_of_the_plan_is_told_in_words(self):
        drag = "drag_lin_kg_s: 413.685 "
        done_already = self.folder / "done.yaml"  # 1 nm off where the vehicle is to be, and the beam's end from the port
        done_already.write_text("model: ease\nvehicle: {p_IS_m: [0.363100001, 0, 0], q_IS: [0, 0, 0, 1]}\n"
                                "beam: {p_IB_m: [0, 0, 0], q_IB: [1, 0, 0, 0], contact: 2}\n"
                                "port: {p_IP_m: [0, 0, 1.524000001], axis_I: [0, 0, -1]}\n"
                                "weights: {time: 1, impulse: 1}\nattach_heights_m: [0]\n")
        cases = [("a weak bound: it knows of the vehicle's linear drag alone", "weak",
                  lambda: self.scenario_with_model((drag, "drag_lin_kg_s: 0.5 "))),
                 ("No lower bound is known: it would follow from the vehicle's linear drag, of which there is none", "none",
                  lambda: self.scenario_with_model((drag, "drag_lin_kg_s: 0 "))),
                 ("No lower bound is known: there is hardly anything to fly", "none", lambda: done_already)]
        for words, gap, make in cases:
            with self.subTest(words):
                path = make()
                line = ssv("plan", path).stdout.splitlines()[1]
                self.assertIn(words, line)
                self.assertNotIn("%", line)
                self.assertEqual(ssv("quote", path).stdout.splitlines()[1].split()[5], gap)


CANDIDATE_SHAPE = {"contact": "integer", "attach_height_m": "real", "ring_angle_rad": "real", "reason": "text",
                   "time_s": "real", "impulse_Ns": "real", "cost": "real", "body": "text", "obstacle": "integer",
                   "clearance_m": "real"}


class CandidatesAndFrontTest(InFolder):
    def answer(self, command, path, *arguments):
        answer = json.loads(ssv(command, path, "--format", "json", *arguments).stdout)
        return answer["quotes"][0]["quote"] if command == "quote" else answer["plan"]["quote"]

    def test_candidates_and_front_come_only_on_request_of_the_command_line_or_of_the_file(self):
        of_file = {"candidates": False, "front": False}
        for key in of_file:
            path = self.scenario(("model: paper", f"model: paper\n{key}: true"))
            off = self.folder / "off.yaml"
            off.write_text(path.read_text().replace("true", "false"))
            for command in ("plan", "quote"):
                with self.subTest(f"{command} {key}"):
                    asked = self.answer(command, PAPER_CASE, f"--{key}")
                    self.assertEqual({k: bool(asked[k]) for k in of_file}, of_file | {key: True})
                    self.assertEqual(self.answer(command, path)[key], asked[key])
                    for answer in (self.answer(command, PAPER_CASE), self.answer(command, off)):
                        self.assertEqual([answer[k] for k in of_file], [[], []])
                        self.assertEqual(answer["cost"], asked["cost"])

    def test_every_contact_and_height_is_a_candidate_and_the_quote_is_the_cheapest(self):
        for path, method in itertools.product(SCENARIOS, METHODS):
            with self.subTest(f"{path.stem} {method}"):
                plan = json.loads(ssv("plan", path, "--candidates", *METHODS[method], "--format", "json").stdout)
                asked, answer = plan["scenario"], plan["plan"]["quote"]
                self.assertEqual(shape(answer["candidates"]), ["any", CANDIDATE_SHAPE])
                options = asked["options"]
                heights = options["attach_heights_m"][:options["num_attach_heights"]] or [1.524, 0, -1.524]
                contacts = [asked["contact"]] if asked["contact"] else [1, 2]
                self.assertEqual([(c["contact"], c["attach_height_m"]) for c in answer["candidates"]],
                                 list(itertools.product(contacts, heights)))
                self.assertEqual(min(c["cost"] for c in answer["candidates"] if not c["reason"]), answer["cost"])
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
        self.assertLess(freed["cost"], 0.998 * given["cost"])
        self.assertLessEqual(freed["cost_lower_bound"], given["cost_lower_bound"])
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
                front, cost = answer["front"], answer
                self.assertEqual(shape(front), ["any", CANDIDATE_SHAPE])
                for one, another in itertools.permutations(front, 2):
                    self.assertFalse(one["time_s"] <= another["time_s"] and one["impulse_Ns"] <= another["impulse_Ns"])
                self.assertEqual(front, sorted(front, key=lambda point: point["time_s"]))
                self.assertTrue(any(point["time_s"] <= cost["time_s"] and point["impulse_Ns"] <= cost["impulse_Ns"]
                                    for point in front))
                w1, w2 = map(float, weights.split(","))
                for point in front:
                    self.assertAlmostEqual(point["cost"], w1 * point["time_s"] + w2 * point["impulse_Ns"], 8)
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
                    self.assertEqual(list(quote), ["file", "scenario", "scene", "quote"])
                    self.assertEqual(without_stamp(quote)["quote"], without_stamp(plan)["plan"]["quote"])
                    self.assertEqual(without_stamp(quote)["scenario"], without_stamp(plan)["scenario"])

    def test_the_table_has_a_row_for_each_file_with_the_same_numbers(self):
        lines = ssv("quote", *SCENARIOS).stdout.splitlines()
        self.assertEqual(len(lines), 1 + len(SCENARIOS))
        self.assertEqual(len({len(line) for line in lines}), 1)
        self.assertEqual(re.split("  +", lines[0]),
                         ["scenario", "J", "time s", "impulse N s", "lower bound", "gap %", "contact", "height m"])
        for line, path, quote in zip(lines[1:], SCENARIOS, self.quotes(SCENARIOS)):
            cost, choice = quote["quote"], quote["quote"]["choice"]
            gap = 100 * (cost["cost"] / cost["cost_lower_bound"] - 1)
            prices = [f"{cost[key]:.3f}" for key in ("cost", "time_s", "impulse_Ns", "cost_lower_bound")]
            where = [str(choice["contact"]), f"{choice['attach_height_m']:+.4f}"]
            self.assertEqual(line.split(), [str(path), *prices, f"{gap:.1f}" if gap <= 100 else "weak", *where])

    def test_a_task_that_is_refused_or_has_no_plan_leaves_the_others_alone_and_the_worst_decides_the_exit_code(self):
        far = self.other("far.yaml", ("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        bad = self.other("bad.yaml", ("standoff_m: 0.3025", "standoff_m: .nan"))
        typo = self.other("typo.yaml", ("standoff_m", "standof_m"))
        alone = {path: self.quotes([path], code=code)[0] for path, code in ((PAPER_CASE, 0), (far, 3), (bad, 2), (typo, 2))}
        self.assertEqual([quote["quote"]["status"] for quote in alone.values()], ["ok", "infeasible", "invalid", "invalid"])
        self.assertEqual(list(alone[far]), ["file", "scenario", "scene", "quote"])
        self.assertEqual(list(alone[bad]), ["file", "quote"])
        same = lambda row: {key: row["quote"][key] for key in row["quote"]}
        for paths, code in (([far, PAPER_CASE], 3), ([typo, far, PAPER_CASE, bad, PAPER_CASE], 2), ([far, bad], 2),
                            ([typo, far], 2), ([PAPER_CASE] * 16, 0)):
            for quote, path in zip(self.quotes(paths, code=code), paths):
                self.assertEqual(same(quote), same(alone[path]))
        done = ssv("quote", typo, far, PAPER_CASE, bad)
        self.assertEqual(done.stderr.splitlines(), [
            f"ssv: {typo}:15:1: standof_m: unknown key; did you mean standoff_m?", f"ssv: {far}: no feasible candidate",
            f"ssv: {bad}:15:13: standoff_m: nan is not a finite number"])
        rows = done.stdout.splitlines()
        self.assertEqual([row.split(maxsplit=1)[1] for row in (rows[1], rows[2], rows[4])],
                         ["refused", "no feasible candidate", "refused"])
        self.assertEqual(done.stdout.count("not feasible: "), 3)

    def test_quotes_go_to_the_file_that_is_named(self):
        file = self.folder / "quotes.json"
        done = ssv("quote", PAPER_CASE, "--format", "json", "--output", file)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertEqual(json.loads(file.read_text())["quotes"][0]["quote"]["status"], "ok")


class ScalarTest(InFolder):
    """The planner in other arithmetics; that their plans are as good is property.scalars' to say."""
    NUMBERS = ("cost", "time_s", "impulse_Ns")

    def answer(self, command, path, *arguments):
        done = ssv(command, path, "--format", "json", *arguments)
        self.assertEqual(done.returncode, 0, done)
        answer = json.loads(done.stdout)
        return answer["plan"] if command == "plan" else answer["quotes"][0]

    def too_heavy(self):
        """Costs some 1e8, and the largest number of fixed point is 6.7e7."""
        return self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-300, 0, 0]"), ("{time: 1, impulse: 1}", "{time: 1000, impulse: 1000}"))

    def test_each_scalar_plans_and_quotes_the_scenarios_much_alike_and_none_like_another(self):
        for path in SCENARIOS:
            plans = {scalar: self.answer("plan", path, "--scalar", scalar) for scalar in ("double", "float", "fixed")}
            self.assertEqual(plans["double"]["plan_hash"], self.answer("plan", path)["plan_hash"])
            self.assertEqual(len({plan["plan_hash"] for plan in plans.values()}), 3)
            for scalar, plan in plans.items():
                with self.subTest(f"{path.stem} {scalar}"):
                    quote, exact = plan["quote"], plans["double"]["quote"]
                    self.assertEqual(self.answer("quote", path, "--scalar", scalar)["quote"]["cost"], quote["cost"])
                    for key in self.NUMBERS:
                        self.assertAlmostEqual(quote[key] / exact[key], 1, delta=0.01)

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
        self.assertEqual(self.answer("plan", path)["quote"]["status"], "ok")
        for command, arguments in (("plan", [path]), ("quote", [PAPER_CASE, path])):
            done = ssv(command, *arguments, "--scalar", "fixed")
            self.assertEqual(done.returncode, 5, done)
            self.assertEqual(done.stderr, f"ssv: {path}: a number does not fit the planner's arithmetic, fixed; ask a planner "
                                          "that computes in double\n")
        self.assertEqual(done.stdout.splitlines()[2].split(maxsplit=1)[1], "numeric overflow")
        done = ssv("plan", path, "--scalar", "fixed", "--format", "json")
        quote = json.loads(done.stdout)["plan"]["quote"]
        self.assertEqual((done.returncode, quote["status"], quote["cost"]), (5, "numeric_overflow", 0))

    def canted(self):
        """Six thrusters around the hull, each tilted against the next, and a long way to go."""
        model = (HOST / "models" / "ease.yaml").read_text()
        lines = [line for line in model.splitlines() if "n_T_S: [" in line]
        for i, line in enumerate(lines):
            cos, sin, up = math.cos(math.radians(60 * i)), math.sin(math.radians(60 * i)), (-1) ** i
            model = model.replace(line, f"    - {{p_ST_m: [{0.22695 * cos:.6f}, {0.22695 * sin:.6f}, {0.2 * up}], "
                                        f"n_T_S: [{-0.7648 * up * sin:.9f}, {0.7648 * up * cos:.9f}, 0.64427]}}")
        (self.folder / "mine.yaml").write_text(model)
        return self.scenario(("model: ease", "model: mine.yaml"), ("p_IS_m: [0, 0, 0]", "p_IS_m: [-20, -10, 3]"), base=PORT1)

    def test_a_scalar_whose_rounding_alone_leads_a_plan_astray_gives_none(self):
        """Six thrusters tilted against each other: turns are made of small differences, of which float has few digits."""
        path = self.canted()
        plans = {scalar: self.answer("plan", path, "--scalar", scalar) for scalar in ("double", "fixed")}
        for scalar, plan in plans.items():
            arrival = plan["arrival"]
            self.assertLess(arrival["rounding_m"] + arrival["lines_m"], 0.005, scalar)
        done = ssv("plan", path, "--scalar", "float")
        self.assertEqual((done.returncode, done.stdout), (5, ""), done)
        self.assertRegex(done.stderr, r"^ssv: .*: flown open loop its plan would end [0-9.e-]+ m and [0-9.e-]+ deg off by what "
                                      r"float rounds alone; ask a planner that computes in double\n$")

    def test_over_lcm_the_planner_must_be_of_the_scalar_asked_for(self):
        over_lcm = [f"--lcm={URL}", "--timeout", "20", "--scalar"]
        with Daemon(URL, "ssv-plannerd-fixed"):
            for command in ("plan", "quote"):
                here = self.answer(command, PAPER_CASE, "--scalar", "fixed")
                self.assertEqual(self.answer(command, PAPER_CASE, *over_lcm, "fixed")["quote"]["cost"], here["quote"]["cost"])
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
        self.assertEqual(json.loads(self.file.read_text())["plan"]["quote"]["status"], "ok")
        self.assert_only("plan.json")

    def test_a_file_that_is_replaced_keeps_its_permissions_and_a_link_stays_a_link(self):
        real = self.folder / "real.json"
        real.write_text("old")
        real.chmod(0o640)
        self.file.symlink_to(real)
        self.assertEqual(self.plan().returncode, 0)
        self.assertTrue(self.file.is_symlink())
        self.assertEqual(real.stat().st_mode & 0o777, 0o640)
        self.assertEqual(json.loads(real.read_text())["plan"]["quote"]["status"], "ok")
        self.assert_only("plan.json", "real.json")

    def test_a_failed_write_leaves_the_old_file_whole(self):
        self.file.write_text("old")
        done = self.plan(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("cannot write", done.stderr)
        self.assertEqual(self.file.read_text(), "old")
        self.assert_only("plan.json")

    def test_what_is_no_plan_leaves_a_good_file_alone_in_every_format(self):
        self.file.write_text("old")
        far = ("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]")
        for change, code in ((("contact: 1", "contact: 9"), 2), (("standoff_m: 0.3025", "standoff_m: 0"), 2), (far, 3)):
            path = self.scenario(change)
            for command, form in itertools.product(("plan", "quote"), ("table", "json")):
                if command == "quote" and code == 3:
                    continue  # that there is no price is an answer among others
                done = ssv(command, path, "--format", form, "--output", self.file)
                self.assertEqual((done.returncode, self.file.read_text()), (code, "old"), done)
                if form == "json":
                    self.assertIn('"status": "in', done.stdout)
        done = ssv("plan", self.folder / "absent.yaml", "--format", "json", "--output", self.file)
        self.assertEqual((done.returncode, self.file.read_text()), (2, "old"))

    def test_a_minus_is_standard_output(self):
        self.file = "-"
        done = self.plan(cwd=self.folder)
        self.assertEqual(json.loads(done.stdout)["plan"]["quote"]["status"], "ok")
        self.assert_only()

    def test_a_link_to_nothing_leads_to_the_new_file_and_a_ring_of_links_is_refused(self):
        (self.folder / "sub").mkdir()
        (self.folder / "sub" / "next.json").symlink_to("../real.json")
        self.file.symlink_to("sub/next.json")
        self.assertEqual(self.plan().returncode, 0)
        self.assertTrue(self.file.is_symlink() and (self.folder / "sub" / "next.json").is_symlink())
        self.assertEqual(json.loads((self.folder / "real.json").read_text())["plan"]["quote"]["status"], "ok")
        self.file = self.folder / "ring.json"
        self.file.symlink_to("ring.json")
        self.assertEqual(self.plan().returncode, 1)

    def test_set_uid_bits_do_not_stay(self):
        self.file.write_text("old")
        self.file.chmod(0o6755)
        self.assertEqual(self.plan().returncode, 0)
        self.assertEqual(self.file.stat().st_mode & 0o7777, 0o755)

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
                    self.assertNotEqual(here["scenario"]["asker"]["request_id"], there["scenario"]["asker"]["request_id"])
                    self.assertEqual(without_stamp(here), without_stamp(there))

    def test_invalid_and_infeasible_come_back_with_the_same_reason_and_exit_code(self):
        with Daemon(URL):
            for change in [("standoff_m: 0.3025", "standoff_m: .nan"), ("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]")]:
                path = self.scenario(change)
                here = ssv("plan", path, "--format", "json")
                there = self.ask(path)
                self.assertEqual(there.returncode, here.returncode)
                self.assertEqual(*(json.loads(done.stdout)["plan"]["quote"]["reason"] for done in (there, here)))
                self.assertEqual(there.stderr, here.stderr)

    def test_quotes_are_those_computed_in_process(self):
        bad = self.folder / "bad.yaml"
        bad.write_text(edited(PAPER_CASE.read_text(), ("standoff_m: 0.3025", "standoff_m: .nan")))
        typo = self.folder / "typo.yaml"
        typo.write_text(edited(PAPER_CASE.read_text(), ("standoff_m", "standof_m")))
        far = self.scenario(("p_IS_m: [0, 0, 0]", "p_IS_m: [-900, 0, 0]"))
        stamped = r'"(asker_id|request_id|epoch_us|planner_id)": "?[0-9a-f]+"?'
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

    def test_an_address_that_cannot_be_opened_is_told_with_what_is_wrong_about_it(self):
        for url, words in (("nonsense", "an address reads udpm://239.255.76.67:7667?ttl=0"),
                           ("nonsense://", "an address reads udpm://239.255.76.67:7667?ttl=0"),
                           ("udpm://10.0.0.1:7667", "'10.0.0.1' is no multicast group, which is 224.0.0.0 to 239.255.255.255"),
                           ("udpm://240.0.0.1", "'240.0.0.1' is no multicast group"),
                           ("udpm://planner:7667?ttl=1", "'planner' is no multicast group"),
                           ("udpm://239.255.76.67:99999", "'99999' is no port, which is 1 to 65535"),
                           ("tcpq://127.0.0.1:1", "no LCM server answers there")):
            with self.subTest(url):
                plan = ssv("plan", PAPER_CASE, f"--lcm={url}")
                daemon = subprocess.run([BIN / "ssv-plannerd", "--lcm-url", url], capture_output=True, text=True, timeout=60)
                for done, line in ((plan, f"no LCM on {url}: "), (daemon, f"cannot open LCM at {url}: ")):
                    self.assertEqual(done.returncode, 4, done)
                    self.assertIn(line, done.stderr)
                    self.assertIn(words, done.stderr)
                    self.assertNotIn("route", done.stderr.splitlines()[-1])


class HostileAnswerTest(InFolder):
    """Whatever comes on the planner's channels: what is no answer is passed over, and nothing crashes the asker."""

    KINDS = {"plan": ("SSV_SCENARIO", "SSV_PLAN"), "quote": ("SSV_SCENARIO_BATCH", "SSV_QUOTE_BATCH")}
    DETAILS = ("--candidates", "--front")

    @classmethod
    def setUpClass(cls):
        cls.good = {}
        for command, (_, channel) in cls.KINDS.items():
            bus = lcm.LCM(URL)
            bus.subscribe(channel, lambda channel, data: cls.good.setdefault(command, data))
            with Daemon(URL):
                done = ssv(command, PAPER_CASE, f"--lcm={URL}", "--timeout", "20", *cls.DETAILS)
                if done.returncode != 0 or bus.handle_timeout(20000) <= 0:
                    raise AssertionError(done)
        # After the fingerprint, the asker, the question's hash and the planner's id comes its version, then its scalar.
        version_at = 8 + 32 + 8 + 8
        length, = struct.unpack_from(">i", cls.good["plan"], version_at)
        cls.counts_at = version_at + 4 + length + 1

    def ask_with_answers(self, command, answers, timeout_s=1):
        """Runs ssv against a stand-in planner that answers every question with all of these, its asker put in."""
        ask_channel, answer_channel = self.KINDS[command]
        bus = lcm.LCM(URL)
        stop = threading.Event()

        def reply(channel, data):
            for answer in answers:
                answer = bytearray(answer)
                answer[8:40] = data[8:40]
                bus.publish(answer_channel, bytes(answer))

        bus.subscribe(ask_channel, reply)

        def serve():
            while not stop.is_set():
                bus.handle_timeout(50)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            return ssv(command, PAPER_CASE, f"--lcm={URL}", "--timeout", str(timeout_s), "--format", "json",
                       *self.DETAILS)
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
        reason_at = quote_at + 17
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
        at = self.counts_at
        self.assert_passed_over("plan", [
            b"\0" * 40,
            self.patched("plan", at, b"\x7f\xff\xff\xff"),  # more legs than memory
            self.patched("plan", at + 4, b"\0\0\0\x41"),  # one arc too many
            self.patched("plan", at + 8, b"\xff\xff\xff\xff"),  # fewer than no segments
            *self.foreign_quotes("plan", at + 16),
        ])

    def test_messages_that_are_no_quotes_for_as_many_tasks_as_asked_are_passed_over(self):
        at = self.counts_at
        two = self.patched("quote", at, b"\0\0\0\2") + self.good["quote"][at + 4:]
        self.assert_passed_over("quote", [
            two,
            self.patched("quote", at, b"\0\0\0\0")[:at + 4],
            self.patched("quote", at, b"\xff\xff\xff\xff"),
            self.patched("quote", at, b"\x7f\xff\xff\xff"),
            *self.foreign_quotes("quote", at + 4),
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
