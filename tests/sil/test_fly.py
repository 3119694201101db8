"""ssv fly from the outside: simulated flights end to end, what they leave behind, and what they say."""
import json
import math
import os
import pty
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import lcm
import ssv as messages

BIN = Path(os.environ["SSV_BIN_DIR"])
SCENARIOS = Path(os.environ["SSV_SOURCE_DIR"]) / "host/scenarios"
ON_AXIS = SCENARIOS / "on_axis.yaml"
DOCKED, FAILED, REFUSED, INFEASIBLE, NO_ANSWER, MISSED, ABORTED, TOUCHED, USAGE = 0, 1, 2, 3, 4, 6, 7, 8, 64
CHILDREN = ["ssv-sim", "ssv-plannerd"]


def url(number):
    """A bus of our own, so that tests which run at the same time do not hear one another."""
    return f"udpm://239.255.76.67:{20000 + (7 * os.getpid() + number) % 20000}?ttl=0"


def children_of(pid):
    listing = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(child) for child in listing.read_text().split()] if listing.exists() else []


def name_of(pid):
    try:
        return Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


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


def comparable(flight):
    """The flight without what differs from run to run by intent: ids, time stamps, and the clock on the wall."""
    flight = json.loads(json.dumps(flight))
    del flight["wall_s"], flight["news_lost"], flight["scenario"]["asker"]
    for part in ("plan", "execution"):
        del flight[part]["answer"]
    return flight


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.empty = self.folder / "empty"
        self.empty.mkdir()
        self.environment = os.environ | {"LCM_DEFAULT_URL": url(0), "TMPDIR": str(self.empty)}

    def tearDown(self):
        self.assertEqual(list(self.empty.iterdir()), [], "no temporary file is left")

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def with_reserve(self, scenario=ON_AXIS):
        return self.file("reserve.yaml", scenario.read_text() + "\nthrust_reserve: 0.2\n")

    def fly(self, *arguments, code=DOCKED):
        done = subprocess.run([BIN / "ssv", "fly", *map(str, arguments)], capture_output=True, text=True, timeout=120,
                              env=self.environment)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done

    def flown(self, *arguments, code=DOCKED):
        return json.loads(self.fly(*arguments, "--sim", "--format", "json", code=code).stdout)

    def start(self, *arguments, **options):
        """A flight, and the two processes that it started, once it is under way."""
        flight = subprocess.Popen([BIN / "ssv", "fly", *map(str, arguments)], text=True, env=self.environment,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
        self.addCleanup(flight.stdout.close)
        self.addCleanup(flight.stderr.close)
        self.addCleanup(flight.wait)
        self.addCleanup(flight.kill)
        for line in flight.stderr:
            if "tracking" in line:
                break
        return flight, children_of(flight.pid)

    def assert_gone(self, children):
        wait_until(lambda: not any(is_running(child) for child in children), "the children are gone")


class Nominal(InFolder):
    def test_a_shipped_scenario_docks_as_predicted(self):
        flight = self.flown(ON_AXIS)
        truth = flight["simulation"]["truth"]
        self.assertEqual((truth["outcome"], flight["execution"]["outcome"]), ("docked", "docked"))
        for event in ("mate", "dock"):
            self.assertLess(truth[event]["position_m"], 0.01)
            self.assertLess(truth[event]["angle_rad"], math.radians(0.5))
        predicted = flight["plan"]["quote"]
        for flown_Ns in (flight["execution"]["impulse_Ns"], truth["impulse_Ns"]):  # as commanded, as given
            self.assertLess(abs(flown_Ns / predicted["impulse_Ns"] - 1), 0.02)
        waited_s = sum(leg["flown"]["wait_s"] for leg in flight["legs"])
        # A twentieth of a second on each side of a wait is told by the message before or after.
        self.assertAlmostEqual(flight["execution"]["flown_s"], predicted["time_s"] + waited_s, delta=0.5)

    def test_the_legs_add_up_to_the_flight_and_the_json_is_a_scenario_too(self):
        path = self.folder / "flight.json"
        done = self.fly(ON_AXIS, "--sim", "--format", "json", "--output", path)
        self.assertEqual(done.stdout, "")
        flight = json.loads(path.read_text())
        self.assertEqual(list(flight), ["scenario", "scene", "plan", "execution", "legs", "flown", "simulation", "news_lost",
                                        "wall_s"])
        self.assertEqual(len(flight["legs"]), flight["plan"]["num_legs"])
        for leg, planned in zip(flight["legs"], flight["plan"]["legs"]):
            self.assertEqual((leg["predicted"]["time_s"], leg["predicted"]["impulse_Ns"]),
                             (planned["duration_s"], planned["impulse_Ns"]))
            self.assertTrue(leg["flown"]["ended"])
        for flown, total in (("time_s", "flown_s"), ("impulse_Ns", "impulse_Ns")):
            self.assertAlmostEqual(sum(leg["flown"][flown] for leg in flight["legs"]), flight["execution"][total], 6)
        self.assertEqual(flight["simulation"]["seed"], "1")
        self.assertIsNone(flight["simulation"]["conditions"])
        again = subprocess.run([BIN / "ssv", "plan", path, "--format", "json"], capture_output=True, timeout=60, check=True)
        self.assertEqual(json.loads(again.stdout)["plan"]["plan_hash"], flight["plan"]["plan_hash"])

    def test_the_table_and_the_progress_have_what_a_person_wants_to_know(self):
        done = self.fly(ON_AXIS, "--sim")
        self.assertRegex(done.stdout, r"\Aon_axis.yaml: docked\n")
        for words in ("predicted s", "flown N s", "in all", "mate: ", "dock: ", "mm and ", "frames heard", "times real time"):
            self.assertIn(words, done.stdout)
        self.assertLessEqual(max(map(len, done.stdout.splitlines())), 120)
        for words in ("uploading", "tracking to mate", "tracking to dock", "the vehicle says: mated"):
            self.assertIn(words, done.stderr)
        self.assertNotIn("\r", done.stderr)

    def test_on_a_terminal_one_line_is_rewritten(self):
        try:
            ours, theirs = pty.openpty()
        except OSError as error:
            self.skipTest(f"no pseudo-terminals here: {error}")
        flight = subprocess.Popen([BIN / "ssv", "fly", ON_AXIS, "--sim", "--rate", "200"], stdout=subprocess.DEVNULL,
                                  stderr=theirs, env=self.environment)
        os.close(theirs)
        text = b""
        try:
            while chunk := os.read(ours, 65536):
                text += chunk
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        self.assertEqual(flight.wait(timeout=30), DOCKED)
        rewritten = re.findall(rb"\r\x1b\[Ktracking to (?:mate|dock): [^\r\n]* beside", text)
        self.assertGreater(len(rewritten), 5, text)

    def test_each_arithmetic_flies_with_its_own_planner(self):
        for scalar in ("float", "fixed"):
            with self.subTest(scalar):
                flight = self.flown(ON_AXIS, "--scalar", scalar)
                self.assertEqual(flight["plan"]["answer"]["planner"]["scalar"], scalar)

    def test_flights_on_one_bus_do_not_disturb_one_another(self):
        daemon = subprocess.Popen([BIN / "ssv-plannerd"], stderr=subprocess.DEVNULL, env=self.environment)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.terminate)
        flights = [subprocess.Popen([BIN / "ssv", "fly", ON_AXIS, "--sim", "--rate", "200", "--format", "json"], text=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=self.environment)
                   for _ in range(2)]
        texts = [flight.communicate(timeout=60)[0] for flight in flights]
        self.assertEqual([flight.returncode for flight in flights], [DOCKED, DOCKED])
        one, other = (comparable(json.loads(text)) for text in texts)
        self.assertEqual(one["simulation"], other["simulation"])


class Rough(InFolder):
    def test_rough_water_is_docked_in_within_its_limits(self):
        flight = self.flown(self.with_reserve(), "--conditions", "rough", "--seed", "5")
        dock = flight["simulation"]["truth"]["dock"]
        self.assertEqual(flight["simulation"]["conditions"], "rough")
        self.assertLess(dock["position_m"], 0.04)
        self.assertLess(dock["angle_rad"], math.radians(2))
        self.assertLess(dock["speed_m_s"], 0.02)

    def test_the_same_seed_is_the_same_flight_at_any_rate_and_another_seed_is_another(self):
        task = self.with_reserve()
        one = self.flown(task, "--conditions", "rough", "--seed", "5")
        again = self.flown(task, "--conditions", "rough", "--seed", "5")
        paced = self.flown(task, "--conditions", "rough", "--seed", "5", "--rate", "250")
        other = self.flown(task, "--conditions", "rough", "--seed", "6")
        self.assertEqual(one["news_lost"] + again["news_lost"] + paced["news_lost"], 0, "else the legs are not exact")
        self.assertEqual(comparable(again), comparable(one))
        self.assertEqual(comparable(paced), comparable(one))
        self.assertGreater(paced["wall_s"], one["execution"]["time_s"] / 250 * 0.9)
        self.assertNotEqual(comparable(other)["simulation"], comparable(one)["simulation"])

    def test_a_vehicle_that_is_driven_off_its_way_to_the_beam_is_planned_anew_and_mates_where_it_was_to(self):
        path = self.file("gusts.yaml", "water: {wander_m_s: [0.016, 0.016, 0.016], wander_time_s: 100}\n"
                                       "navigation: {rate_Hz: 10}\n"
                                       "mate_limit: {position_m: 0.04}\ndock_limit: {position_m: 0.04}\n")
        task = self.file("ease.yaml", (SCENARIOS / "paper_case.yaml").read_text().replace("model: paper", "model: ease") +
                         "\nthrust_reserve: 0.2\n")
        flight = self.flown(task, "--conditions", path, "--seed", "8")
        self.assertGreater(flight["execution"]["num_plans"], 1)
        self.assertLess(flight["simulation"]["truth"]["mate"]["position_m"], 0.04)

    def test_a_dock_that_forgives_nothing_is_missed(self):
        path = self.file("strict.yaml", "navigation: {rate_Hz: 10, position_m: {white: 0.005}}\n"
                                        "dock_limit: {position_m: 0.00001}\n")
        flight = self.flown(ON_AXIS, "--conditions", path, code=MISSED)
        self.assertEqual((flight["execution"]["outcome"], flight["simulation"]["truth"]["outcome"]), ("missed", "missed"))
        self.assertGreater(flight["simulation"]["truth"]["dock"]["attempts"], 0)
        self.assertFalse(flight["legs"][-1]["flown"]["ended"])

    def test_a_plan_without_reserve_is_hinted_at(self):
        self.assertIn("thrust_reserve: 0.2", self.fly(ON_AXIS, "--sim", "--conditions", "calm").stderr)
        self.assertNotIn("thrust_reserve", self.fly(self.with_reserve(), "--sim", "--conditions", "calm").stderr)


class Clearance(InFolder):
    def test_a_flight_in_still_water_keeps_as_clear_as_its_plan(self):
        for scenario in sorted((SCENARIOS / "clear").glob("*.yaml")):
            with self.subTest(scenario.name):
                flight = self.flown(scenario)
                found, planned = flight["simulation"]["truth"]["clearance"], flight["plan"]["clearance"]
                print(f"{scenario.name}: {1e3 * found['least_m']:.1f} mm flown, {1e3 * planned['certified_m']:.1f} certified")
                self.assertGreater(found["least_m"], planned["certified_m"] - 0.001)  # it tracks to less than that here
                self.assertEqual(found["margin_m"], flight["scenario"]["margin_m"])
        table = self.fly(scenario, "--sim").stdout
        self.assertRegex(table, r"\n  kept clear by \d+\.\d mm of obstacle 0 \(the vehicle at \d+\.\d s\); planned \d+\.\d mm, "
                                r"margin 30\.0 mm\n")
        self.assertNotIn("clear", self.fly(ON_AXIS, "--sim").stdout, "nothing stands around")

    def test_a_flight_that_strays_by_more_than_its_plan_keeps_clear_touches(self):
        """Beside the transit a post, which the plan passes on the side of +y within a few millimetres; and a navigation that
        is off by 2 cm along y."""
        task = self.file("graze.yaml", ON_AXIS.read_text() + "\nthrust_reserve: 0.2\nscene:\n  obstacles:\n"
                                       "    - capsule: {p_I_m: [-9, 0, -2], to_I_m: [9, 0, -2], radius_m: 0.1}\n")
        off = self.file("off.yaml", "navigation: {rate_Hz: 20, position_m: {bias: [0, 0.02, 0]}}\n")
        flight = self.flown(task, "--conditions", off, code=TOUCHED)
        planned, found = flight["plan"]["clearance"], flight["simulation"]["truth"]["clearance"]
        self.assertEqual((flight["execution"]["outcome"], found["obstacle"]), ("docked", 0))
        self.assertAlmostEqual(found["least_m"], planned["seen_m"] - 0.02, delta=0.006)  # seen to 5 mm, flown to 1
        self.assertLess(found["least_m"], 0)
        done = self.fly(task, "--sim", "--conditions", off, code=TOUCHED)
        self.assertRegex(done.stdout, r"\n  TOUCHED: \d+\.\d mm deep in obstacle 0 \(the (vehicle|beam) at ")


class Ending(InFolder):
    def test_an_interrupt_stops_the_vehicle_and_the_flight_reports(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(number.name):
                flight, children = self.start(ON_AXIS, "--sim", "--rate", "20", "--format", "json")
                self.assertEqual([name_of(child) for child in children], CHILDREN)
                time.sleep(1)
                flight.send_signal(number)
                out, _ = flight.communicate(timeout=30)
                self.assertEqual(flight.returncode, ABORTED)
                told = json.loads(out)
                self.assertEqual(told["execution"]["outcome"], "stopped")
                self.assertEqual(told["simulation"]["truth"]["outcome"], "unfinished")
                self.assertLess(told["simulation"]["truth"]["speed_m_s"], 0.005)  # it flew at 13 mm/s
                self.assert_gone(children)

    def test_a_second_interrupt_ends_it_at_once(self):
        flight, children = self.start(ON_AXIS, "--sim", "--rate", "0.5")  # where braking takes its time
        flight.send_signal(signal.SIGINT)
        time.sleep(0.05)
        flight.send_signal(signal.SIGINT)
        begun_s = time.monotonic()
        flight.communicate(timeout=30)
        self.assertEqual(flight.returncode, ABORTED)
        self.assertLess(time.monotonic() - begun_s, 2)
        self.assert_gone(children)

    def test_a_killed_ssv_leaves_no_process(self):
        flight, children = self.start(ON_AXIS, "--sim", "--rate", "20")
        flight.kill()
        flight.wait()
        self.assertEqual(len(children), 2)
        self.assert_gone(children)

    def test_the_terminal_s_interrupt_reaches_ssv_alone(self):
        flight, children = self.start(ON_AXIS, "--sim", "--rate", "20", start_new_session=True)
        for child in children:
            self.assertNotEqual(os.getpgid(child), flight.pid)
        os.killpg(flight.pid, signal.SIGINT)
        flight.communicate(timeout=30)
        self.assertEqual(flight.returncode, ABORTED)

    def test_a_child_that_ends_early_ends_the_flight(self):
        for index, code in ((0, ABORTED), (1, NO_ANSWER)):
            with self.subTest(CHILDREN[index]):
                flight, children = self.start(ON_AXIS, "--sim", "--rate", "20")
                os.kill(children[index], signal.SIGKILL)
                _, err = flight.communicate(timeout=30)
                self.assertEqual(flight.returncode, code, err)
                self.assert_gone(children)


class Wrong(InFolder):
    def test_conditions_and_scenarios_that_are_none_have_their_exit_codes(self):
        unknown = self.file("unknown.yaml", "water: {mean: 3}\n")
        no_yaml = self.file("no.yaml", "water: [\n")
        bad_task = self.file("bad.yaml", ON_AXIS.read_text().replace("port: 1", "port: 4"))
        far = self.file("far.yaml", ON_AXIS.read_text().replace("p_IS_m: [0, 0, -3]", "p_IS_m: [-900, 0, -3]"))
        for arguments, code, words in (
            ((ON_AXIS, "--sim", "--conditions", "stormy"), REFUSED, ("stormy", "conditions")),
            ((ON_AXIS, "--sim", "--conditions", self.folder / "none.yaml"), REFUSED, ("none.yaml", "cannot open")),
            ((ON_AXIS, "--sim", "--conditions", unknown), REFUSED, ("unknown.yaml:1", "mean", "no condition")),
            ((ON_AXIS, "--sim", "--conditions", no_yaml), REFUSED, ("no.yaml", "not YAML")),
            ((bad_task, "--sim"), REFUSED, ("hub.port: '4'",)),
            ((self.folder / "none.yaml", "--sim"), REFUSED, ("none.yaml",)),
            ((far, "--sim"), INFEASIBLE, ("no feasible candidate",)),
            ((ON_AXIS, "--sim", "--output", self.folder / "no" / "folder"), FAILED, ("cannot write",)),
        ):
            with self.subTest(code=code, words=words):
                done = self.fly(*arguments, code=code)
                for word in words:
                    self.assertIn(word, done.stderr)

    def test_usage_errors_and_help(self):
        for arguments in ((), (ON_AXIS,), (ON_AXIS, "--seed", "1", "--lcm"), (ON_AXIS, "--sim", "--rate", "0"),
                          (ON_AXIS, "--sim", "--rate", "fast"), (ON_AXIS, "--sim", "--seed", "-1"),
                          (ON_AXIS, ON_AXIS, "--sim"), (ON_AXIS, "--sim", "--candidates")):
            with self.subTest(arguments=arguments):
                self.fly(*arguments, code=USAGE)
        help_text = self.fly("--help").stdout
        for words in ("MOVES THE REAL VEHICLE", "Exit codes", "6  missed", "7  aborted", "8  touched"):
            self.assertIn(words, help_text)

    def test_without_a_bus_it_says_what_is_missing(self):
        self.environment["LCM_DEFAULT_URL"] = "tcpq://127.0.0.1:1"
        done = self.fly(ON_AXIS, "--sim", code=NO_ANSWER)
        self.assertIn("LCM", done.stderr)


class RealVehicle(InFolder):
    def test_without_a_planner_or_a_vehicle_nobody_flies(self):
        self.assertIn("nobody answered", self.fly(ON_AXIS, "--lcm", url(1), "--timeout", "2", code=NO_ANSWER).stderr)
        daemon = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", url(1)], stderr=subprocess.DEVNULL)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.terminate)
        done = self.fly(ON_AXIS, "--lcm", url(1), "--timeout", "2", code=NO_ANSWER)
        self.assertIn("hears a vehicle", done.stderr)

    def test_the_planner_that_hears_a_vehicle_flies_and_an_interrupt_stops_the_vehicle(self):
        plan = self.folder / "plan.json"
        subprocess.run([BIN / "ssv", "plan", ON_AXIS, "--format", "json", "--output", plan], check=True, timeout=60)
        sim = subprocess.Popen([BIN / "ssv-sim", plan, "--link", "udp-listen:0"], text=True, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
        port = re.search(r"port (\d+)", sim.stderr.readline())[1]
        bus = ["--lcm-url", url(2)]
        planners = [subprocess.Popen([BIN / "ssv-plannerd", *bus, *link], stderr=subprocess.DEVNULL)
                    for link in ((), ("--link", f"udp:127.0.0.1:{port}"))]
        for process in (sim, *planners):
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
        self.addCleanup(sim.stdout.close)
        self.addCleanup(sim.stderr.close)
        flight, children = self.start(ON_AXIS, "--lcm", url(2), "--format", "json")
        self.assertEqual(children, [])
        self.assertIn("flies another task", self.fly(ON_AXIS, "--lcm", url(2), code=ABORTED).stderr)
        time.sleep(1)
        flight.send_signal(signal.SIGINT)
        out, err = flight.communicate(timeout=30)
        self.assertEqual(flight.returncode, ABORTED, err)
        told = json.loads(out)
        self.assertEqual(told["execution"]["outcome"], "stopped")
        self.assertNotIn("simulation", told)
        sim.send_signal(signal.SIGINT)
        truth = json.loads(sim.communicate(timeout=10)[0])
        self.assertLess(truth["speed_m_s"], 0.005)
        self.assertGreater(truth["impulse_Ns"], 1)


class Bus(InFolder):
    def test_truth_and_estimate_are_on_the_bus_ten_times_a_second(self):
        heard = {"SSV_VEHICLE_TRUTH": [], "SSV_VEHICLE_STATE": []}
        bus = lcm.LCM(url(0))
        for channel, states in heard.items():
            bus.subscribe(channel, lambda _, data, states=states: states.append(messages.vehicle_state_t.decode(data))
                          ).set_queue_capacity(10000)
        path = self.folder / "flight.json"
        flight = subprocess.Popen([BIN / "ssv", "fly", ON_AXIS, "--sim", "--rate", "100", "--format", "json", "--output", path],
                                  stderr=subprocess.DEVNULL, env=self.environment)
        while flight.poll() is None:
            bus.handle_timeout(50)
        while bus.handle_timeout(50) > 0:
            pass
        told = json.loads(path.read_text())
        truths, states = heard["SSV_VEHICLE_TRUTH"], heard["SSV_VEHICLE_STATE"]
        self.assertAlmostEqual(len(truths), 10 * told["execution"]["time_s"], delta=20)
        plan_hash = f"{truths[-1].plan_hash & (2 ** 64 - 1):016x}"
        self.assertEqual(plan_hash, told["plan"]["plan_hash"])
        self.assertTrue(truths[-1].docked)
        by_time = {round(10 * truth.time_s): truth for truth in truths}
        compared = 0
        for state in states:
            truth = by_time.get(round(10 * state.time_s))
            if truth is not None and not truth.docked:
                self.assertLess(math.dist(state.X_IS.p_m, truth.X_IS.p_m), 0.01)
                compared += 1
        self.assertGreater(compared, 1000)


if __name__ == "__main__":
    unittest.main()
