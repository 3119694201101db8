"""ssv-sim and ssv-vehicle from the outside: lockstep over the link, the verdict, conditions, signals."""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["SSV_BIN_DIR"])
SCENARIOS = pathlib.Path(os.environ["SSV_SOURCE_DIR"]) / "host/scenarios"
PILOT = os.environ["SSV_SIM_PILOT"]
DOCKED, MISSED, UNFINISHED, TOUCHED = 0, 1, 2, 3
ROUGH = """
water: {wander_m_s: [0.005, 0.005, 0.005], wander_time_s: 60}
thrusters: {gain_spread: 0.05, lag_s: 0.2}
navigation: {rate_Hz: 10, position_m: {white: 0.005}, attitude_rad: {white: 0.0087}}
mate_limit: {position_m: 0.04, angle_rad: 0.035}
dock_limit: {position_m: 0.04, angle_rad: 0.035, speed_m_s: 0.02}
"""


class Sim(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.plan = pathlib.Path(cls.scratch.name) / "plan.json"
        subprocess.run([BIN / "ssv", "plan", SCENARIOS / "on_axis.yaml", "--format", "json", "--output", cls.plan],
                       check=True, timeout=60)

    def file(self, name, text):
        path = pathlib.Path(self.scratch.name) / name
        path.write_text(text)
        return path

    def conditions(self, text):
        return self.file("conditions.yaml", text)

    def start(self, *options, plan=None):
        sim = subprocess.Popen([BIN / "ssv-sim", plan or self.plan, "--link", "udp-listen:0", "--lockstep", "0", *options],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(sim.stdout.close)
        self.addCleanup(sim.stderr.close)
        self.addCleanup(sim.wait)
        self.addCleanup(sim.kill)
        ports = [re.search(r"port (\d+)", sim.stderr.readline())[1] for _ in range(2)]
        return sim, ports

    def fly(self, *options, stop=(), plan=None):
        sim, ports = self.start(*options, plan=plan)
        begun = time.monotonic()
        pilot = subprocess.run([PILOT, "on_axis", *ports, *stop], capture_output=True, text=True, timeout=120)
        took_s = time.monotonic() - begun
        self.assertEqual(pilot.returncode, 0, pilot.stderr)
        if sim.poll() is None:
            sim.send_signal(signal.SIGINT)
        out, _ = sim.communicate(timeout=10)
        return sim.returncode, out, took_s, pilot.stdout

    def test_a_plan_flown_in_lockstep_docks_and_a_rerun_is_the_same_to_the_last_digit(self):
        code, out, took_s, _ = self.fly()
        truth = json.loads(out)
        print(f"lockstep with the link: {truth['time_s'] / took_s:.0f} times real time")
        self.assertEqual((code, truth["outcome"]), (DOCKED, "docked"), out)
        self.assertLess(truth["dock"]["position_m"], 0.01)
        self.assertLess(truth["dock"]["angle_rad"], 0.0087)
        self.assertIsNone(truth["clearance"], "nothing stands around")
        self.assertEqual(self.fly()[:2], (code, out))

    def test_rough_water_makes_open_loop_miss_and_another_seed_is_another_flight(self):
        path = self.conditions(ROUGH)
        code, out, *_ = self.fly("--conditions", path, "--seed", "3", stop=("400",))
        self.assertEqual((code, json.loads(out)["outcome"]), (MISSED, "missed"), out)
        self.assertEqual(self.fly("--conditions", path, "--seed", "3", stop=("400",))[1], out)
        self.assertNotEqual(self.fly("--conditions", path, "--seed", "4", stop=("400",))[1], out)

    def test_what_is_planted_on_the_way_is_touched_and_what_is_beside_it_is_not(self):
        """on_axis goes straight from (0, 0, -3) to the beam: a ball is put in the middle of its transit, and beside it."""
        plan = json.loads(self.plan.read_text())
        legs = [leg for leg in plan["plan"]["legs"] if leg["phase"] == "transit"]
        x, y, z = ((a + b) / 2 for a, b in zip(legs[0]["X_IS_start"]["p_m"], legs[-1]["X_IS_end"]["p_m"]))
        for off_m, code in ((0, TOUCHED), (40, DOCKED)):
            with self.subTest(off_m=off_m):
                ball = {"kind": "capsule", "p_I_m": [x, y, z], "axis_I": [0, 0, 0], "length_m": 0, "radius_m": 0.2}
                ball["p_I_m"][1] += off_m
                plan["scene"] |= {"num_obstacles": 1, "obstacles": [ball]}
                plan["scenario"] |= {"obstacles": "0" * 15 + "1", "margin_m": 0.03}
                flown_code, out, *_ = self.fly(plan=self.file("planted.json", json.dumps(plan)))
                truth = json.loads(out)
                self.assertEqual((flown_code, truth["outcome"]), (code, "docked"), out)
                found = truth["clearance"]
                self.assertEqual(found["margin_m"], 0.03)
                if off_m == 0:
                    self.assertEqual((found["body"], found["obstacle"]), ("vehicle", 0))
                    self.assertLess(found["least_m"], -0.3)
                    self.assertTrue(0 < found["t_s"] < truth["mate"]["t_s"], found)
                else:
                    self.assertEqual(found["obstacle"], 64)  # its own beam
                    self.assertGreater(found["least_m"], 0)

    def test_when_the_beats_end_the_vehicle_stops_and_says_why(self):
        code, out, _, pilot = self.fly(stop=("20",))
        truth = json.loads(out)
        self.assertEqual((code, truth["outcome"], truth["phase"]), (UNFINISHED, "unfinished", 5), out)
        self.assertIn("progress", truth["reason"])
        self.assertEqual(pilot.split()[0], "5")

    def test_conditions_that_are_none_are_refused_with_their_place(self):
        for text, words in (("water: {mean: 3}", ("mean", "no condition")), ("wind: {}", ("wind", "no group")),
                            ("thrusters: {gain_error: [1, 2]}", ("gain_error", "list of 6")),
                            ("thrusters: {curve: {effort: [-1, 1]}}", ("effort and force_N",)),
                            ("navigation: {delay_s: -1}", ("0 or more",)), ("water: [1]", ("map",))):
            with self.subTest(text=text):
                done = subprocess.run([BIN / "ssv-sim", self.plan, "--conditions", self.conditions(text)],
                                      capture_output=True, text=True, timeout=10)
                self.assertEqual(done.returncode, 65, done.stderr)
                for word in words:
                    self.assertIn(word, done.stderr)

    def test_it_runs_by_the_clock_too_and_an_interrupt_ends_it_with_a_verdict(self):
        sim = subprocess.Popen([BIN / "ssv-sim", self.plan, "--link", "udp-listen:0", "--rate", "10"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(sim.kill)
        time.sleep(1)
        sim.send_signal(signal.SIGINT)
        out, _ = sim.communicate(timeout=10)
        truth = json.loads(out)
        self.assertEqual((sim.returncode, truth["outcome"]), (UNFINISHED, "unfinished"))
        self.assertTrue(4 < truth["time_s"] < 14, truth["time_s"])

    def test_usage_errors_have_their_exit_codes(self):
        for program, arguments, code in (("ssv-sim", (), 64), ("ssv-sim", ("no_such_file",), 65),
                                         ("ssv-sim", (self.plan, "--link", "tcp:1"), 69), ("ssv-sim", ("--help",), 0),
                                         ("ssv-vehicle", ("argument",), 64), ("ssv-vehicle", ("--link", "udp:1"), 69),
                                         ("ssv-vehicle", ("--at", "1,2"), 64), ("ssv-vehicle", ("--help",), 0)):
            with self.subTest(program=program, arguments=arguments):
                done = subprocess.run([BIN / program, *arguments], capture_output=True, text=True, timeout=10)
                self.assertEqual(done.returncode, code, done.stderr)


class Bench(unittest.TestCase):
    def test_ssv_vehicle_sends_heartbeats_and_ends_on_an_interrupt(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as planner:
            planner.bind(("127.0.0.1", 0))
            planner.settimeout(5)
            vehicle = subprocess.Popen([BIN / "ssv-vehicle", "--link", f"udp:127.0.0.1:{planner.getsockname()[1]}"],
                                       stdout=subprocess.PIPE, text=True)
            self.addCleanup(vehicle.kill)
            frame = planner.recv(2048)
            self.assertEqual(frame[0], 0xfd)  # a frame of MAVLink 2
            vehicle.send_signal(signal.SIGINT)
            out, _ = vehicle.communicate(timeout=10)
        self.assertEqual(vehicle.returncode, 0)
        self.assertIn("disarmed", out)


if __name__ == "__main__":
    unittest.main()
