"""The daemon with a vehicle, from the outside: who may have it fly, stopping and pausing, and a daemon that is killed.

Real processes on the real clock: ssv-plannerd, ssv-sim on a UDP link, LCM between. SSV_LONG=1 kills 50 daemons.
"""
import json
import os
import random
import re
import select
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm

import ssv

BIN = Path(os.environ["SSV_BIN_DIR"])
SCENARIO = Path(os.environ["SSV_SOURCE_DIR"]) / "host/scenarios/on_axis.yaml"
SEED = int(os.environ.get("SSV_SEED", "20261128"))
LONG = "SSV_LONG" in os.environ
E = ssv.execution_t
WORDS = {"optimal": 0, "paper": 1, "quick": 0, "best": 1}
STOP_S = 1.2  # the dead-man's second and the beat before it
BRAKE_S = 30  # at most


def fill(message, values):
    """Takes over what a JSON object of the same keys says."""
    for key, value in values.items():
        if not hasattr(message, key):
            continue
        if isinstance(value, dict):
            fill(getattr(message, key), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for part, one in zip(getattr(message, key), value):
                fill(part, one)
        elif isinstance(value, list):
            size = len(getattr(message, key))
            setattr(message, key, (value + [0.0] * size)[:size])
        elif isinstance(value, str):
            setattr(message, key, WORDS[value] if key in ("method", "effort") else int(value, 16))
        else:
            setattr(message, key, value)


class Tank:
    """A bus of its own with a simulated vehicle and, once started, a planner; all of them end with close()."""

    def __init__(self, plan, number, link="udp-listen:0", options=()):
        self.url = f"udpm://239.255.76.67:{20000 + (os.getpid() * 61 + number) % 20000}?ttl=0"
        self.lcm = lcm.LCM(self.url)
        self.status = self.execution = self.plan = self.truth = None
        for channel, kind, name in (("SSV_PLANNER_STATUS", ssv.planner_status_t, "status"),
                                    ("SSV_EXECUTION", ssv.execution_t, "execution"),
                                    ("SSV_PLAN", ssv.plan_t, "plan"),
                                    ("SSV_VEHICLE_TRUTH", ssv.vehicle_state_t, "truth")):
            self.lcm.subscribe(channel, lambda _, data, kind=kind, name=name: setattr(self, name, kind.decode(data)))
        self.sim = subprocess.Popen([BIN / "ssv-sim", plan, "--link", link, f"--lcm-url={self.url}", *options],
                                    stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.port = re.search(r"port (\d+)", self.sim.stderr.readline())[1] if link.startswith("udp") else None
        self.planners = []

    def start(self, *options):
        self.status = None
        self.planners.append(subprocess.Popen([BIN / "ssv-plannerd", "-l", self.url, *options],
                                              stderr=subprocess.DEVNULL))
        return self.planners[-1]

    def start_linked(self):
        return self.start("--link", f"udp:127.0.0.1:{self.port}")

    def wait(self, condition, seconds):
        """Whether the condition comes true in time, and how long that took."""
        begun = time.monotonic()
        while not condition() and time.monotonic() - begun < seconds:
            self.lcm.handle_timeout(50)
        return condition(), time.monotonic() - begun

    def ask(self, scenario, request_id, epoch_us, planner_id=None):
        question = ssv.scenario_t()
        fill(question, scenario)
        question.asker.asker_id, question.asker.request_id, question.asker.epoch_us = 7, request_id, epoch_us
        question.asker.planner_id = self.status.planner.planner_id if planner_id is None else planner_id
        self.plan = None
        task = ssv.task_t()
        task.scenario = question
        self.lcm.publish("SSV_EXECUTE", task.encode())
        self.wait(lambda: self.plan is not None and self.plan.answer.asker.request_id == request_id, 10)
        return self.plan

    def control(self, command):
        message = ssv.control_t()
        message.command = command
        self.lcm.publish("SSV_CONTROL", message.encode())

    def close(self):
        for process in self.planners:
            process.kill()
            process.wait()
        self.sim.send_signal(signal.SIGINT)
        out, _ = self.sim.communicate(timeout=10)
        return json.loads(out)


class Cable:
    """Two serial ports with a cable between, as pseudo-terminals, which carries so many bytes in a second each way."""

    def __init__(self, bytes_per_s):
        try:
            self.ends = [os.openpty(), os.openpty()]
        except OSError as error:
            raise unittest.SkipTest(f"no pseudo-terminals here: {error}")
        self.devices = [os.ttyname(slave) for _, slave in self.ends]
        self.bytes_per_s, self.count, self.is_open = bytes_per_s, [0, 0], True
        self.threads = [threading.Thread(target=self.carry, args=(0, 1)), threading.Thread(target=self.carry, args=(1, 0))]
        for thread in self.threads:
            thread.start()

    def carry(self, source, target):
        while self.is_open:
            ready, _, _ = select.select([self.ends[source][0]], [], [], 0.05)
            data = os.read(self.ends[source][0], 64) if ready else b""
            if data:
                time.sleep(len(data) / self.bytes_per_s)
                os.write(self.ends[target][0], data)
                self.count[source] += len(data)

    def close(self):
        self.is_open = False
        for thread in self.threads:
            thread.join()
        for master, slave in self.ends:
            os.close(master)
            os.close(slave)


class Flights(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.plan = Path(cls.scratch.name) / "plan.json"
        subprocess.run([BIN / "ssv", "plan", SCENARIO, "--format", "json", "--output", cls.plan], check=True, timeout=60)
        cls.scenario = json.loads(cls.plan.read_text())["scenario"]

    def tank(self, number=0):
        tank = Tank(self.plan, number)
        self.addCleanup(lambda: tank.sim.poll() is None and tank.close())
        return tank

    def flying(self, tank):
        """A tank whose vehicle is under way."""
        tank.start_linked()
        self.assertTrue(tank.wait(lambda: tank.status is not None, 10)[0])
        plan = tank.ask(self.scenario, 11, 1000)
        self.assertEqual(plan.quote.status, ssv.quote_t.STATUS_OK, plan.quote.reason)
        reached, _ = tank.wait(lambda: tank.execution is not None and tank.execution.state == E.STATE_TRACKING, 20)
        self.assertTrue(reached)

    def refused(self, tank, words, **how):
        plan = tank.ask(self.scenario, **how)
        self.assertEqual(plan.quote.status, ssv.quote_t.STATUS_INVALID)
        self.assertIn(words, plan.quote.reason)

    def test_a_planner_without_a_vehicle_refuses_to_fly(self):
        tank = self.tank()
        tank.start()
        self.assertTrue(tank.wait(lambda: tank.status is not None, 10)[0])
        self.assertEqual(tank.status.link, ssv.planner_status_t.LINK_NONE)
        self.refused(tank, "no vehicle", request_id=1, epoch_us=1)

    def test_one_task_flies_at_a_time_a_recording_flies_none_and_a_stop_ends_it(self):
        tank = self.tank(1)
        self.flying(tank)
        self.refused(tank, "another task", request_id=12, epoch_us=2000)
        self.refused(tank, "must name its planner", request_id=13, epoch_us=2000, planner_id=0)
        tank.control(ssv.control_t.COMMAND_STOP)
        self.assertTrue(tank.wait(lambda: tank.execution.state == E.STATE_ENDED, 40)[0])
        self.assertEqual(tank.execution.outcome, E.OUTCOME_STOPPED)
        again = tank.ask(self.scenario, 11, 1000)  # the same bytes as before
        self.assertEqual(again.quote.status, ssv.quote_t.STATUS_OK)
        self.refused(tank, "must be newer", request_id=14, epoch_us=1000)
        tank.wait(lambda: False, 1.5)
        self.assertEqual((tank.status.flights, tank.status.flying_request_id), (1, 0))
        self.assertEqual(tank.close()["phase"], 5)

    def test_a_pause_holds_the_vehicle_and_its_clock_until_it_is_to_go_on(self):
        tank = self.tank(2)
        self.flying(tank)
        tank.wait(lambda: tank.execution.plan_time_s > 1, 10)
        tank.control(ssv.control_t.COMMAND_PAUSE)
        tank.wait(lambda: tank.execution.clock_rate == 0, 5)
        stood_s = tank.execution.plan_time_s
        tank.wait(lambda: False, 3)
        self.assertEqual(tank.execution.plan_time_s, stood_s)
        self.assertEqual(tank.execution.state, E.STATE_TRACKING)
        still = [abs(v) for v in tank.truth.v_IS_S_m_s]
        self.assertLess(max(still), 0.01)
        tank.control(ssv.control_t.COMMAND_CONTINUE)
        self.assertTrue(tank.wait(lambda: tank.execution.plan_time_s > stood_s + 1, 10)[0])

    def test_a_vehicle_at_the_end_of_a_serial_cable_is_flown_like_any_other(self):
        cable = Cable(5760)  # 57,600 baud
        self.addCleanup(cable.close)
        tank = Tank(self.plan, 4, f"serial:{cable.devices[0]}:57600")
        self.addCleanup(lambda: tank.sim.poll() is None and tank.close())
        tank.start_linked = lambda: tank.start("--link", f"serial:{cable.devices[1]}:57600")
        self.flying(tank)
        sent, begun = list(cable.count), time.monotonic()
        tank.wait(lambda: tank.execution.plan_time_s > 5, 30)
        took_s = time.monotonic() - begun
        down, up = [(now - before) / took_s / 5760 for now, before in zip(cable.count, sent)]
        print(f"tracking takes {100 * down:.0f} % of 57,600 baud down and {100 * up:.0f} % up; {tank.execution.link_lost} frames "
              f"lost down, {tank.execution.link_lost_up} up")
        self.assertLess(max(down, up), 0.5)
        self.assertEqual((tank.execution.link_lost, tank.execution.link_damaged), (0, 0))
        self.assertLess(tank.execution.beside_m, 0.01)
        tank.control(ssv.control_t.COMMAND_STOP)
        self.assertTrue(tank.wait(lambda: tank.execution.state == E.STATE_ENDED, 40)[0])
        self.assertEqual(tank.close()["phase"], 5)

    def test_with_a_key_the_vehicle_obeys_who_has_it_and_nobody_else(self):
        keys = {}
        for name, digits in (("right", "0123456789abcdef" * 4), ("wrong", "f" * 64), ("short", "ab")):
            keys[name] = Path(self.scratch.name) / name
            keys[name].write_text(digits + "\n")
            keys[name].chmod(0o600)
        tank = Tank(self.plan, 5, options=("--key", keys["right"]))
        self.addCleanup(lambda: tank.sim.poll() is None and tank.close())
        for key in (("--key", keys["wrong"]), ()):
            with self.subTest(key=key):
                tank.execution = None
                planner = tank.start("--link", f"udp:127.0.0.1:{tank.port}", *key)
                self.assertTrue(tank.wait(lambda: tank.status is not None, 10)[0])
                self.assertEqual(tank.ask(self.scenario, 30 + len(key), 1000).quote.status, ssv.quote_t.STATUS_OK)
                self.assertTrue(tank.wait(lambda: tank.execution is not None and tank.execution.outcome != 0, 60)[0])
                self.assertEqual(tank.execution.outcome, E.OUTCOME_SILENT)
                planner.kill()
                planner.wait()
        tank.execution = None
        tank.start_linked = lambda: tank.start("--link", f"udp:127.0.0.1:{tank.port}", "--key", keys["right"])
        self.flying(tank)
        tank.wait(lambda: tank.execution.plan_time_s > 1, 10)
        keys["right"].chmod(0o644)
        for key, words in ((keys["right"], "chmod 600"), (keys["short"], "64 hexadecimal"), ("nowhere", "No such file")):
            done = subprocess.run([BIN / "ssv-plannerd", "-l", tank.url, "--link", "udp-listen:0", "--key", key],
                                  capture_output=True, text=True, timeout=10)
            self.assertEqual(done.returncode, 69)
            self.assertIn(words, done.stderr)

    def test_a_daemon_that_is_told_to_end_stops_the_vehicle_first(self):
        tank = self.tank(3)
        self.flying(tank)
        tank.wait(lambda: False, 1)
        tank.planners[0].terminate()
        self.assertEqual(tank.planners[0].wait(timeout=10), 0)
        truth = tank.close()
        self.assertIn(truth["phase"], (4, 5))
        self.assertIn("by command", truth["reason"])

    def kill(self, number, after_s, results):
        """Kills the planner and starts another one; what came of it."""
        tank = Tank(self.plan, 10 + number)
        try:
            self.flying(tank)
            tank.wait(lambda: False, after_s)
            first = tank.status.planner.planner_id
            tank.planners[0].kill()
            killed = time.monotonic()
            tank.start_linked()
            tank.wait(lambda: tank.status is not None and tank.status.planner.planner_id != first, 10)
            served_s = time.monotonic() - killed
            second = tank.status.planner.planner_id
            tank.wait(lambda: time.monotonic() - killed > 0.3, 1)
            tank.wait(lambda: not any(tank.truth.u_N), STOP_S + BRAKE_S + 5)
            dead_s = time.monotonic() - killed
            tank.wait(lambda: tank.status.link == ssv.planner_status_t.LINK_HEARD, 3)
            tank.wait(lambda: False, 1)
            results.append((served_s, dead_s, first != second, tank.status.flying_request_id, tank.status.flights,
                            tank.status.link, any(tank.truth.u_N), tank.close()))
        finally:
            if tank.sim.poll() is None:
                tank.close()

    def test_a_daemon_that_is_killed_leaves_a_safe_vehicle_and_the_next_one_inherits_nothing(self):
        draw = random.Random(SEED)
        count, at_once = (50, 5) if LONG else (5, 5)
        results = []
        for first in range(0, count, at_once):
            threads = [threading.Thread(target=self.kill, args=(k, draw.uniform(0, 6), results))
                       for k in range(first, first + at_once)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(len(results), count)
        served = [r[0] for r in results]
        dead = [r[1] for r in results]
        print(f"{count} kills: the next daemon serves after at most {max(served):.2f} s, thrust is zero after at most "
              f"{max(dead):.2f} s")
        for served_s, dead_s, is_new, flying, flights, link, has_thrust, truth in results:
            self.assertLess(served_s, 1)
            self.assertLess(dead_s, STOP_S + BRAKE_S)
            self.assertTrue(is_new)
            self.assertEqual((flying, flights, has_thrust), (0, 0, False))
            self.assertEqual(link, ssv.planner_status_t.LINK_HEARD)
            self.assertEqual(truth["phase"], 5)
            self.assertIn("progress", truth["reason"])


if __name__ == "__main__":
    print(f"seed {SEED}")
    unittest.main()
