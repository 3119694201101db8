"""What a person sees who watches the planner with lcm-spy.

SpyProbe.java does what lcm-spy does with a message, up to the window. It watches a real ssv-plannerd answer a real
`ssv plan`; what it decodes with the Java types must be what the C programs at the two ends say.
"""

import json
import math
import os
import queue
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from types import SimpleNamespace

import lcm
from ssv import plan_t, planner_status_t

BIN = Path(os.environ["SSV_BIN_DIR"])
SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
JAVA = os.environ["SSV_JAVA"]
TYPES_JAR = Path(os.environ["SSV_TYPES_JAR"])
PROBE_CLASS_PATH = os.environ["SSV_PROBE_CLASS_PATH"]
PICTURES = Path(os.environ["SSV_PICTURES_DIR"])
sys.path.insert(0, str(SOURCE / "lcmtypes"))
from sample_plan import pose_along  # noqa: E402

XVFB = shutil.which("Xvfb")
JAVA_OPENS_WINDOWS = (Path(JAVA).resolve().parent.parent / "lib/libawt_xawt.so").exists()

DEADLINE_S = 60  # generous: reached only when something is broken
STATUS, PLAN, SCENARIO = "SSV_PLANNER_STATUS", "SSV_PLAN", "SSV_SCENARIO"
BATCH, QUOTES = "SSV_SCENARIO_BATCH", "SSV_QUOTE_BATCH"


def free_url():
    """A multicast URL on a port that no other test listens to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("", 0))
        return f"udpm://239.255.76.67:{s.getsockname()[1]}?ttl=0"


class Probe:
    """SpyProbe on a URL; keeps what it printed."""

    def __init__(self, test, url, class_path):
        self.test = test
        self.log = tempfile.TemporaryFile("w+")
        test.addCleanup(self.log.close)
        self.process = subprocess.Popen([JAVA, "-Djava.net.preferIPv4Stack=true", "-cp", class_path, "SpyProbe", url],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True)
        test.addCleanup(stop, self.process)
        self.lines = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.wait_for("that it listens", lambda m: m.get("listening"))

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(json.loads(line))
        self.lines.put(None)

    def wait_for(self, what, wanted):
        """The next message that is wanted; the ones before it are dropped."""
        seen = []
        end = time.monotonic() + DEADLINE_S
        while True:
            try:
                message = self.lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                message = None
            if message is None:
                self.log.seek(0)
                self.test.fail(f"lcm-spy did not show {what}; it showed {seen[-5:]} and said:\n{self.log.read()}")
            if wanted(message):
                return message
            seen.append(message)


def stop(process):
    for pipe in (process.stdin, process.stdout):
        if pipe and not pipe.closed:
            pipe.close()
    if process.poll() is None:
        process.terminate()
    try:
        process.wait(DEADLINE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def start_planner(test, url):
    process = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", url], stdin=subprocess.DEVNULL)
    test.addCleanup(stop, process)


# By key and, where two types have that key, by one beside it.
WORDS = {"status": ("ok", "infeasible", "invalid", "numeric_overflow"), "phase": ("transit", "transfer"),
         "ramp": ("full_reverse", "drag_only", "optimal"), "method": ("optimal", "paper"), "scalar": ("double", "float", "fixed"), "effort": ("quick", "best"),
         ("kind", "phase"): ("translate", "turn", "screw"), ("kind", "t_s"): ("mate", "dock"),
         ("kind", "axis_I"): ("capsule", "wall"), ("kind", "to_I_m"): ("none", "box", "cylinder"),
         ("body", "obstacle"): ("vehicle", "beam")}


def in_json(wire):
    """The fields of a message as JSON should have them: words for enums, digits for hashes and ids."""
    if isinstance(wire, list):
        return [in_json(element) for element in wire]
    if not isinstance(wire, dict):
        return wire
    fields = {}
    for key, value in wire.items():
        words = next((WORDS[name] for name in WORDS if name == key or (name[0] == key and name[1] in wire)), None)
        is_bits = key.endswith(("_hash", "_id")) or key == "left" or (key == "obstacles" and "left" in wire)
        fields[key] = f"{value % 2**64:016x}" if is_bits else words[value] if words else in_json(value)
    return fields


def scene_in_json(wire):
    """Likewise of a scene, of which as many obstacles are some as it counts."""
    return in_json(wire | {"obstacles": wire["obstacles"][:wire["num_obstacles"]]})


class WatchingThePlanner(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        self.url = free_url()

    def test_lcm_spy_shows_status_question_and_plan_as_the_planner_and_the_asker_have_them(self):
        probe = Probe(self, self.url, f"{PROBE_CLASS_PATH}:{TYPES_JAR}")
        start_planner(self, self.url)

        status = probe.wait_for("the status of the idle planner", lambda m: m["channel"] == STATUS)
        self.assertEqual(status["type"], "ssv.planner_status_t")
        version = subprocess.run([BIN / "ssv-plannerd", "--version"], capture_output=True, text=True, check=True).stdout
        self.assertIn(status["fields"]["planner"]["version"], version.split())
        self.assertEqual((status["fields"]["received"], status["fields"]["last_request_id"]), (0, 0))
        self.assertGreaterEqual(status["fields"]["uptime_us"], 0)

        asked = subprocess.run([BIN / "ssv", "plan", SOURCE / "host/scenarios/paper_case.yaml", f"--lcm={self.url}",
                                "--method", "paper", "--candidates", "--format", "json"], capture_output=True, text=True,
                               timeout=DEADLINE_S)
        self.assertEqual(asked.returncode, 0, asked.stderr)
        received = json.loads(asked.stdout)
        request_id = int.from_bytes(bytes.fromhex(received["plan"]["answer"]["asker"]["request_id"]), signed=True)

        scenario = probe.wait_for("the question", lambda m: m["channel"] == SCENARIO)
        self.assertEqual(scenario["type"], "ssv.task_t")
        self.assertEqual(in_json(scenario["fields"]["scenario"]), received["scenario"])
        self.assertEqual(scene_in_json(scenario["fields"]["scene"]), received["scene"])
        plan = probe.wait_for("the plan", lambda m: m["channel"] == PLAN)
        self.assertEqual(plan["type"], "ssv.plan_t")
        self.assertEqual(in_json(plan["fields"]), received["plan"])

        status_after = probe.wait_for("that one scenario was accepted",
                                      lambda m: m["channel"] == STATUS and m["fields"]["accepted"] > 0)
        after = status_after["fields"]
        self.assertEqual((after["accepted"], after["last_request_id"]), (1, request_id))
        self.assertEqual(after["repeated"], after["received"] - 1)  # the asker may have asked more than once
        self.assertEqual(after["worst_plan_us"], after["last_plan_us"])
        self.assertEqual([after[name] for name in after if name.startswith("rejected") or name == "infeasible"], [0] * 9)
        self.assertGreater(after["uptime_us"], status["fields"]["uptime_us"])

        self.assertEqual((after["task_type_hash"], after["plan_type_hash"], after["planner_status_type_hash"]),
                         (scenario["type_hash"], plan["type_hash"], status_after["type_hash"]))

    def test_lcm_spy_shows_batches_and_their_quotes(self):
        probe = Probe(self, self.url, f"{PROBE_CLASS_PATH}:{TYPES_JAR}")
        start_planner(self, self.url)
        files = sorted((SOURCE / "host/scenarios").glob("*.yaml"))
        asked = subprocess.run([BIN / "ssv", "quote", *files, f"--lcm={self.url}", "--candidates", "--front", "--format",
                                "json"], capture_output=True, text=True, timeout=DEADLINE_S)
        self.assertEqual(asked.returncode, 0, asked.stderr)
        received = json.loads(asked.stdout)["quotes"]

        batch = probe.wait_for("the batch", lambda m: m["channel"] == BATCH)
        self.assertEqual((batch["type"], batch["fields"]["num_scenarios"]), ("ssv.scenario_batch_t", len(files)))
        for scenario, row in zip(batch["fields"]["scenarios"], received):
            self.assertEqual(in_json(scenario) | {"asker": None}, row["scenario"] | {"asker": None})  # the batch has it
        answer = probe.wait_for("the quotes", lambda m: m["channel"] == QUOTES)
        self.assertEqual((answer["type"], answer["fields"]["num_quotes"]), ("ssv.quote_batch_t", len(files)))
        for quote, row in zip(answer["fields"]["quotes"], received):
            self.assertEqual(in_json(quote), row["quote"])
        status = probe.wait_for("that the batch was priced", lambda m: m["channel"] == STATUS and m["fields"]["batches"] > 0)
        self.assertEqual((status["fields"]["batches"], status["fields"]["quoted"]), (1, len(files)))
        self.assertEqual((status["fields"]["scenario_batch_type_hash"], status["fields"]["quote_batch_type_hash"]),
                         (batch["type_hash"], answer["type_hash"]))

    def test_without_the_jar_lcm_spy_does_not_know_the_type(self):
        probe = Probe(self, self.url, PROBE_CLASS_PATH)
        start_planner(self, self.url)
        status = probe.wait_for("a status", lambda m: m["channel"] == STATUS)
        self.assertIsNone(status["type"])

    def test_lcm_spy_does_not_misread_a_message_of_another_version_of_the_type(self):
        probe = Probe(self, self.url, f"{PROBE_CLASS_PATH}:{TYPES_JAR}")
        bus = lcm.LCM(self.url)
        captured = []
        bus.subscribe(STATUS, lambda channel, data: captured.append(data))
        start_planner(self, self.url)
        while not captured:
            self.assertGreater(bus.handle_timeout(DEADLINE_S * 1000), 0, "no status from the planner")
        type_hash, = struct.unpack_from(">q", captured[0])

        bus.publish("SAME_TYPE", captured[0])
        same = probe.wait_for("the captured status", lambda m: m["channel"] == "SAME_TYPE")
        self.assertEqual((same["type"], same["type_hash"]), ("ssv.planner_status_t", type_hash))
        bus.publish("OTHER_VERSION", struct.pack(">q", type_hash ^ 1) + captured[0][8:])
        other = probe.wait_for("the changed status", lambda m: m["channel"] == "OTHER_VERSION")
        self.assertIsNone(other["type"])


def as_objects(json_text):
    return json.loads(json_text, object_hook=lambda fields: SimpleNamespace(**fields))


@unittest.skipUnless(XVFB and JAVA_OPENS_WINDOWS, "needs Xvfb and a Java that opens windows (Debian packages xvfb, default-jre)")
class InItsWindow(unittest.TestCase):
    """lcm-spy itself, on a display that nobody sees."""

    @classmethod
    def setUpClass(cls):
        PICTURES.mkdir(exist_ok=True)
        read, write = os.pipe()
        cls.xvfb = subprocess.Popen([XVFB, "-displayfd", str(write), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
                                    pass_fds=(write,), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(stop, cls.xvfb)
        os.close(write)
        with os.fdopen(read) as display:
            cls.environment = os.environ | {"DISPLAY": ":" + display.readline().strip()}

    def setUp(self):
        self.url = free_url()
        self.bus = lcm.LCM(self.url)

    def open_spy(self):
        self.log = tempfile.TemporaryFile("w+")
        self.addCleanup(self.log.close)
        self.spy = subprocess.Popen([JAVA, "-Djava.net.preferIPv4Stack=true", "-cp", f"{PROBE_CLASS_PATH}:{TYPES_JAR}", "ssv.spy.SpyWindow",
                                     self.url], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True,
                                    env=self.environment)
        self.addCleanup(stop, self.spy)
        self.ask("channels")

    def ask(self, command, argument=""):
        self.spy.stdin.write(f"{command} {argument}\n")
        self.spy.stdin.flush()
        line = self.spy.stdout.readline()
        if not line:
            self.log.seek(0)
            self.fail(f"lcm-spy has ended:\n{self.log.read()}")
        answer = json.loads(line)
        if isinstance(answer, dict):
            self.assertNotIn("error", answer)
        return answer

    def wait_for(self, condition, what):
        end = time.monotonic() + DEADLINE_S
        while True:
            value = condition()
            if value:
                return value
            self.assertLess(time.monotonic(), end, f"never seen: {what}")
            time.sleep(0.05)

    def publish_until(self, channel, data, condition, what):
        def once():
            self.bus.publish(channel, data)
            return condition()

        return self.wait_for(once, what)

    def captured_plan(self, *options):
        """A plan as it went over the bus, and as its asker has it."""
        datagrams = []
        listener = lcm.LCM(self.url)
        listener.subscribe(PLAN, lambda channel, data: datagrams.append(data))
        planner = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", self.url], stdin=subprocess.DEVNULL)
        self.addCleanup(stop, planner)
        asked = subprocess.run([BIN / "ssv", "plan", *options, f"--lcm={self.url}", "--format", "json"], capture_output=True, text=True,
                               timeout=DEADLINE_S)
        while not datagrams:
            self.assertGreater(listener.handle_timeout(DEADLINE_S * 1000), 0)
        stop(planner)
        return datagrams[0], json.loads(asked.stdout)["plan"]

    def test_a_double_click_on_a_captured_plan_shows_its_thrusts_and_its_way_from_above(self):
        data, plan = self.captured_plan(SOURCE / "host/scenarios/clear/port2_either.yaml")
        self.open_spy()
        self.publish_until(PLAN, data, lambda: PLAN in self.ask("channels"), "the channel")
        self.assertIn(PLAN, self.ask("open", PLAN))
        shown = self.wait_for(lambda: (content := self.ask("read", PLAN))["way"] and content, "the plan")
        self.assertIn(f"J = {plan['quote']['cost']:.3f} (none below {plan['quote']['cost_lower_bound']:.3f})", shown["words"][0])
        self.assertIn(plan["plan_hash"], shown["words"][0])

        self.assertEqual([(trace["name"], trace["y"]) for trace in shown["traces"]], [(f"T{i}", f"T{i} [N]") for i in range(1, 7)])
        self.assertEqual(shown["traces"][5]["x"], "t [s]")
        for i, trace in enumerate(shown["traces"]):
            wanted = [point for segment in plan["segments"]
                      for point in ([segment["t_s"], segment["u_start_N"][i]], [segment["t_s"] + segment["duration_s"], segment["u_end_N"][i]])]
            self.assertEqual(trace["points"], wanted)

        legs = as_objects(json.dumps(plan)).legs
        self.assertEqual(len(shown["way"]), len(legs))
        for leg, points in zip(legs, shown["way"]):
            for i in range(len(points)):
                wanted, _ = pose_along(leg, leg.length * i / (len(points) - 1))
                self.assertLess(math.dist(points[i], wanted), 1e-9)  # both in doubles
            self.assertLess(math.dist(points[-1], leg.X_IS_end.p_m), 1e-6)  # the plan's own end, integrated otherwise
        time.sleep(1)  # for the charts, which are painted by a thread of their own
        self.ask("picture", PICTURES / "spy_plan.png")

    def test_a_plan_of_wild_numbers_does_not_harm_the_window(self):
        data, _ = self.captured_plan(SOURCE / "host/scenarios/paper_case.yaml")
        self.open_spy()
        self.publish_until(PLAN, data, lambda: PLAN in self.ask("channels"), "the channel")
        self.ask("open", PLAN)
        before = self.wait_for(lambda: (content := self.ask("read", PLAN))["way"] and content, "the plan")
        wild = plan_t.decode(data)
        wild.quote.cost = math.nan
        for leg in wild.legs:
            leg.X_IS_start.p_m = [1e300, -1e300, math.inf]
            leg.length = math.inf
        for segment in wild.segments:
            segment.t_s, segment.u_start_N = math.nan, [math.inf] * 6
        shown = self.publish_until(PLAN, wild.encode(), lambda: (content := self.ask("read", PLAN)) != before and content, "the wild plan")
        self.assertEqual((shown["way"], shown["traces"][0]["points"]), ([], []))
        wild.quote.status, wild.quote.reason, wild.num_legs, wild.num_segments = 99, "<html><b>no", 0, 0
        shown = self.publish_until(PLAN, wild.encode(), lambda: "status 99" in (content := self.ask("read", PLAN))["words"][0] and content, "that")
        self.assertIn("<html><b>no", shown["words"][0])
        self.publish_until(PLAN, data, lambda: self.ask("read", PLAN) == before, "the sound plan again")

    def test_a_double_click_on_the_status_shows_what_each_planner_does_in_a_second(self):
        self.open_spy()
        heard = []
        self.bus.subscribe(STATUS, lambda channel, data: heard.append(planner_status_t.decode(data)))
        for _ in range(2):
            start_planner(self, self.url)
            time.sleep(0.3)  # both tell once a second, and lcm-spy keeps the last message only
        self.wait_for(lambda: STATUS in self.ask("channels"), "the channel")
        self.ask("open", STATUS)
        self.wait_for(lambda: len(self.ask("read", STATUS)["tabs"]) == 2, "both planners")
        files = sorted((SOURCE / "host/scenarios").glob("*.yaml"))
        for _ in range(3):
            subprocess.run([BIN / "ssv", "quote", *files, f"--lcm={self.url}"], capture_output=True, check=True, timeout=DEADLINE_S)
            subprocess.run([BIN / "ssv", "plan", files[0], f"--lcm={self.url}"], capture_output=True, check=True, timeout=DEADLINE_S)

        def rows(number):
            return {name: (total, rate) for name, total, rate in self.ask("read", STATUS)["tables"][number]}

        self.wait_for(lambda: [rows(k)["plans"][0] for k in range(2)] == ["3", "3"], "three plans of each, who were all asked")
        while self.bus.handle_timeout(0) > 0:
            pass
        shown = self.ask("read", STATUS)
        for number, tab in enumerate(shown["tabs"]):
            told = [status for status in heard if f"planner {status.planner.planner_id % 2**64:016x}" == tab]
            traces = {trace["name"]: trace["points"] for trace in shown["traces"][3 * number:3 * number + 3]}
            for name, field in (("questions", "received"), ("plans", "accepted"), ("prices", "quoted")):
                uptimes = [status.uptime_us / 1e6 for status in told]
                counts = [getattr(status, field) for status in told]
                wanted = {b: (m - k) / (b - a) for a, b, k, m in zip(uptimes, uptimes[1:], counts, counts[1:])}
                self.assertGreater(len(traces[name]), 0)
                for up_s, rate in traces[name]:
                    if up_s in wanted:
                        self.assertAlmostEqual(rate, wanted[up_s], delta=1e-6 * max(1, wanted[up_s]))
                self.assertGreaterEqual(sum(up_s in wanted for up_s, _ in traces[name]), len(traces[name]) - 1)
        time.sleep(3)
        self.ask("picture", PICTURES / "spy_status.png")

    def test_spy_sh_opens_lcm_spy_with_both_windows(self):
        tree = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, tree)
        (tree / "host").mkdir()
        (tree / "build").mkdir()
        shutil.copy(SOURCE / "host/spy.sh", tree / "host")
        (tree / "build/venv").symlink_to(sys.prefix)
        (tree / "build/share").symlink_to(TYPES_JAR.parent)
        spy = subprocess.Popen(["bash", tree / "host/spy.sh", "--lcm-url", self.url], env=self.environment, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, start_new_session=True)
        self.addCleanup(stop, spy)
        said = ""
        while not {"PlanPlugin", "StatusPlugin"} <= set(re.findall(r"ssv\.spy\.(\w+)@", said)):
            line = spy.stdout.readline()
            self.assertTrue(line, said)
            said += line


class OpeningTheWindow(unittest.TestCase):
    """host/spy.sh up to the point where lcm-spy would open."""

    def setUp(self):
        self.tree = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.tree)
        (self.tree / "host").mkdir()
        (self.tree / "build").mkdir()
        shutil.copy(SOURCE / "host/spy.sh", self.tree / "host")

    def spy(self, *arguments):
        environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        return subprocess.run(["bash", self.tree / "host/spy.sh", *arguments], env=environment, capture_output=True,
                              text=True, timeout=DEADLINE_S)

    def assert_says(self, result, exit_code, *words):
        self.assertEqual(result.returncode, exit_code, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)

    def test_spy_in_a_fresh_clone_says_how_to_build(self):
        self.assert_says(self.spy(), 1, "not built", "bash host/demo.sh")

    def test_spy_without_the_jar_says_which_package_brings_the_compiler(self):
        (self.tree / "build/venv").symlink_to(sys.prefix)
        self.assert_says(self.spy(), 1, "ssv_lcmtypes.jar", "apt-get install default-jdk", "bash host/demo.sh")

    def test_spy_without_a_display_says_so(self):
        (self.tree / "build/venv").symlink_to(sys.prefix)
        (self.tree / "build/share").symlink_to(TYPES_JAR.parent)
        self.assert_says(self.spy(), 1, "no display", "ssh -X")

    def test_spy_explains_itself_when_called_wrongly(self):
        self.assert_says(self.spy("--url"), 64, 'unknown argument "--url"', "Usage:")
        self.assert_says(self.spy("--lcm-url"), 64, "needs a URL", "Usage:")
        help_ = self.spy("--help")
        self.assertEqual((help_.returncode, help_.stderr), (0, ""))
        for word in ("--lcm-url", "Example:", "Exit codes:"):
            self.assertIn(word, help_.stdout)


if __name__ == "__main__":
    unittest.main()
