"""ssv watch from the outside: browsers and bare clients look on while a simulated flight happens, strangers talk on the bus, and
pages of others ask for what is not theirs."""
import http.client
import json
import math
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm
import ssv as messages

BIN = Path(os.environ["SSV_BIN_DIR"])
SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
PICTURES = Path(os.environ["SSV_PICTURES_DIR"])
sys.path.insert(0, str(SOURCE / "tests/support"))
from browser import CHROMIUM, Browser  # noqa: E402

OK, FAILED, NO_ANSWER, USAGE = 0, 1, 4, 64
DEADLINE_S = 60
TASK = SOURCE / "host/scenarios/clear/on_axis.yaml"
CHANNELS = ("SSV_SCENARIO", "SSV_EXECUTE", "SSV_PLAN", "SSV_PLANNER_STATUS", "SSV_EXECUTION", "SSV_VEHICLE_STATE", "SSV_VEHICLE_TRUTH")
number = 0


class Viewer(threading.Thread):
    """A bare client of the events."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=DEADLINE_S)
        self.connection.request("GET", "/events")
        self.answer = self.connection.getresponse()
        self.events, self.numbers = [], []
        self.start()

    def run(self):
        identity = None
        try:
            for line in self.answer:
                if line.startswith(b"id: "):
                    identity = int(line[4:])
                elif line.startswith(b"data: "):
                    self.numbers.append(identity)
                    self.events.append(json.loads(line[6:]))
        except (OSError, ValueError, http.client.HTTPException):
            pass  # closed

    def wait(self, wanted):
        deadline_s = time.monotonic() + DEADLINE_S
        while not any(wanted(event) for event in list(self.events)):
            if time.monotonic() > deadline_s:
                raise TimeoutError(f"never came; {len(self.events)} events, last {self.events[-1:]}")
            time.sleep(0.02)


class Listener(threading.Thread):
    """Everything that goes over the bus."""

    def __init__(self, url):
        super().__init__(daemon=True)
        self.bus, self.heard, self.ended = lcm.LCM(url + "&recv_buf_size=4194304"), [], False
        self.bus.subscribe(".*", lambda channel, data: self.heard.append((channel, data))).set_queue_capacity(0)
        self.start()

    def run(self):
        while self.bus.handle_timeout(100) or not self.ended:
            pass

    def of(self, channel, kind):
        return [kind.decode(data) for name, data in list(self.heard) if name == channel]

    def end(self):
        self.ended = True
        self.join()


class OnBus(unittest.TestCase):
    def setUp(self):
        global number
        number += 1
        self.url = f"udpm://239.255.76.67:{20000 + (13 * os.getpid() + number) % 20000}?ttl=0"
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        PICTURES.mkdir(exist_ok=True)

    def watch(self, *options):
        process = subprocess.Popen([BIN / "ssv", "watch", "--lcm", self.url, "--port", "0", *options], stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        first = process.stderr.readline()
        self.port = int(re.search(r"http://127\.0\.0\.1:(\d+)/", first)[1])
        return process

    def fly(self, task, *options, code=OK):
        done = subprocess.run([BIN / "ssv", "fly", task, "--sim", f"--lcm={self.url}", "--format", "json", *options], capture_output=True, text=True,
                              timeout=200)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def task(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def ask(self, path="/", method="GET", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        connection.putrequest(method, path, skip_host=True)
        for key, value in ({"Host": f"127.0.0.1:{self.port}"} | {key.replace("_", "-"): value for key, value in headers.items()}).items():
            if value is not None:
                connection.putheader(key, value)
        connection.endheaders()
        answer = connection.getresponse()
        self.addCleanup(connection.close)
        return answer


class Watching(OnBus):
    @unittest.skipUnless(CHROMIUM, "needs Chromium (Debian package chromium)")
    def test_viewers_miss_nothing_of_a_flight_and_who_joins_late_sees_all_of_it(self):
        task = self.task("task.yaml", TASK.read_text() + "\nthrust_reserve: 0.2\n")
        options = ("--conditions", "rough", "--seed", "3")
        began_s = time.monotonic()
        alone = self.fly(task, *options)
        alone_s = time.monotonic() - began_s
        self.watch()
        bus = Listener(self.url)
        address = f"http://127.0.0.1:{self.port}/"
        with Browser() as early, Browser() as late:
            early.open(address)
            early.wait("ssv.state().live.snapshots > 0")
            viewers = [Viewer(self.port), Viewer(self.port)]
            flights = []
            flying = threading.Thread(target=lambda: flights.append(self.fly(task, *options, "--rate", "25")), daemon=True)
            flying.start()
            early.wait("ssv.state().tasks === 1 && ssv.state().duration_s > 100 && ssv.state().live.rows.truth > 900")
            early.screenshot(PICTURES / "watch.png")
            late.open(address)
            late.wait("window.ssv && ssv.state().tasks === 1")
            joined = late.evaluate("ssv.state()")
            flying.join(DEADLINE_S)
            flight, = flights
            for browser in (early, late):
                browser.wait("ssv.state().live.execution && ssv.state().live.execution.state === 'ended'")
            for viewer in viewers:
                viewer.wait(lambda event: event.get("execution", None) and event["execution"]["state"] == "ended")
            for browser in (early, late):
                browser.wait("Math.abs(ssv.state().duration_s - ssv.state().live.execution.flown_s) < 0.3")  # and that was drawn
            shown, shown_late = early.evaluate("ssv.state()"), late.evaluate("ssv.state()")
            self.assertEqual(early.complaints() + late.complaints(), [])
            self.assertEqual({url.removeprefix(address) for url in early.requests() + late.requests()}, {"", "events"})
        bus.end()
        states, truths = bus.of("SSV_VEHICLE_STATE", messages.vehicle_state_t), bus.of("SSV_VEHICLE_TRUTH", messages.vehicle_state_t)
        # No message is missing on the page or at the bare clients; a truth or two before the start are of no flight yet.
        self.assertEqual(shown["live"]["gaps"], 0)
        self.assertEqual(shown["live"]["rows"]["estimate"], len(states))
        start_s = states[0].time_s - flight["flown"]["estimate"]["rows"][0][0]
        told = [truth for truth in truths if start_s <= truth.time_s <= states[-1].time_s]
        self.assertAlmostEqual(shown["live"]["rows"]["truth"], len(told), delta=3)
        for viewer in viewers:
            numbers = viewer.numbers
            self.assertEqual(numbers[1:], list(range(numbers[0] + 1, numbers[-1] + 1)))
            self.assertEqual(sum(event.get("track") == "estimate" for event in viewer.events), len(states))
        # All of it is seen by who came late: from the start to where it was, and then the rest.
        self.assertGreater(joined["duration_s"], 100)
        self.assertAlmostEqual(shown_late["duration_s"], shown["duration_s"], delta=0.2)
        self.assertEqual(shown_late["live"]["snapshots"], 1)
        for state in (shown, shown_late):
            self.assertTrue(state["docked"])
            self.assertLess(math.dist(state["X_IB"][0][:3], flight["plan"]["quote"]["X_IB_final"]["p_m"]), 0.04)
        # Whoever looks on changes nothing and slows nobody: the same flight to the last bit, and as long at full speed.
        self.assertEqual(flight["simulation"], alone["simulation"])
        began_s = time.monotonic()
        again = self.fly(task, *options)
        watched_s = time.monotonic() - began_s
        self.assertEqual(again["simulation"], alone["simulation"])
        print(f"{len(states)} states, {len(truths)} truths; a flight takes {alone_s:.2f} s unwatched, {watched_s:.2f} s watched", flush=True)

    @unittest.skipUnless(CHROMIUM, "needs Chromium (Debian package chromium)")
    def test_an_assembly_grows_and_another_task_begins_a_picture_of_its_own(self):
        first = json.loads(subprocess.run([BIN / "ssv", "plan", TASK, "--format", "json"], capture_output=True, text=True, check=True).stdout)
        final = first["plan"]["quote"]["X_IS_final"]
        second = self.task("second.yaml", f"model: ease\nvehicle: {{p_IS_m: {final['p_m']}, q_IS: {final['q']}}}\n"
                                          "beam: {p_IB_m: [0, 3, -2], q_IB: [1, 0, 0, 0], contact: either}\n"
                                          "port: {p_IP_m: [3, 5, 0], axis_I: [0, 1, 0]}\nweights: {time: 1, impulse: 1}\n")
        self.watch()
        with Browser() as browser:
            browser.open(f"http://127.0.0.1:{self.port}/")
            browser.wait("ssv.state().live.snapshots > 0")
            self.assertEqual(browser.evaluate("ssv.state().tasks"), 0)
            self.fly(TASK)
            browser.wait("ssv.state().tasks === 1 && ssv.state().live.execution.outcome === 'docked'")
            self.fly(second)
            browser.wait("ssv.state().tasks === 2 && ssv.state().live.execution.outcome === 'docked'")
            state = browser.evaluate("(ssv.setTime(1e9), ssv.state())")
            self.assertLess(math.dist(state["X_IB"][0][:3], first["plan"]["quote"]["X_IB_final"]["p_m"]), 0.04)
            browser.screenshot(PICTURES / "watch_assembly.png")
            self.fly(SOURCE / "host/scenarios/on_axis.yaml")
            browser.wait("ssv.state().tasks === 1")
            self.assertEqual(browser.complaints(), [])

    @unittest.skipUnless(CHROMIUM, "needs Chromium (Debian package chromium)")
    def test_a_plan_that_is_only_asked_for_is_shown_and_strangers_do_not_break_the_page(self):
        process = self.watch()
        planner = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", self.url], stderr=subprocess.DEVNULL)
        self.addCleanup(planner.wait)
        self.addCleanup(planner.terminate)
        bus, listener = lcm.LCM(self.url), Listener(self.url)
        with Browser() as browser:
            browser.open(f"http://127.0.0.1:{self.port}/")
            browser.wait("ssv.state().live.planners === 1")
            subprocess.run([BIN / "ssv", "plan", TASK, f"--lcm={self.url}"], check=True, capture_output=True)
            browser.wait("ssv.state().tasks === 1")
            before = browser.evaluate("(ssv.setTime(50), ssv.state())")
            plan, = listener.of("SSV_PLAN", messages.plan_t)[-1:]
            draw = random.Random(1)
            state = messages.vehicle_state_t()
            state.plan_hash, state.time_s, state.X_IS.q = plan.plan_hash, math.nan, [1, 0, 0, 0]
            news = messages.execution_t()
            news.answer.asker.asker_id, news.answer.asker.request_id = plan.answer.asker.asker_id, plan.answer.asker.request_id
            news.answer.planner.planner_id, news.plan_hash, news.sequence, news.time_s = plan.answer.planner.planner_id, plan.plan_hash, 1, math.inf
            plan.segments[0].u_start_N = [1e6] * 6
            plan.quote.reason = "</script><script>document.title = 'taken'</script>"
            status = messages.planner_status_t()
            status.planner.planner_id, status.planner.version, status.planner.scalar = 7, "<img src=x onerror=document.title='taken'>", 99
            forged = [("SSV_PLAN", plan.encode()), ("SSV_EXECUTION", news.encode()), ("SSV_VEHICLE_STATE", state.encode()),
                      ("SSV_VEHICLE_TRUTH", state.encode()), ("SSV_PLANNER_STATUS", status.encode())]
            for channel, data in forged:
                bus.publish(channel, data)
                for _ in range(20):
                    cut = bytearray(data[:draw.randrange(len(data))])
                    bus.publish(channel, bytes(cut))
                    changed = bytearray(data)
                    changed[draw.randrange(8, len(changed))] ^= 1 << draw.randrange(8)
                    bus.publish(channel, bytes(changed))
            for channel in CHANNELS:
                for size in (0, 1, 8, 1000, 60000):
                    bus.publish(channel, draw.randbytes(size))
            subprocess.run([BIN / "ssv", "plan", SOURCE / "host/scenarios/on_axis.yaml", f"--lcm={self.url}"], check=True, capture_output=True)
            browser.wait(f"ssv.state().duration_s !== {before['duration_s']}")  # it goes on
            self.assertEqual(browser.complaints(), [])
            self.assertNotIn("taken", browser.evaluate("document.title"))
            self.assertEqual(browser.evaluate("document.images.length"), 0)
        listener.end()
        process.terminate()
        self.assertEqual(process.wait(), OK)
        heard, refused = map(int, re.search(r"heard (\d+) messages, (\d+) of them not", process.stderr.read()).groups())
        self.assertGreater(refused, 100)
        self.assertGreater(heard, refused)

    def test_it_sends_nothing(self):
        listener = Listener(self.url)
        self.watch()
        viewer = Viewer(self.port)
        viewer.wait(lambda event: event["kind"] == "snapshot")
        time.sleep(1.5)
        listener.end()
        self.assertEqual([channel for channel, _ in listener.heard if channel != "LCM_SELF_TEST"], [])

    def test_a_viewer_who_does_not_read_holds_up_nobody(self):
        self.watch()
        asleep = socket.create_connection(("127.0.0.1", self.port))
        self.addCleanup(asleep.close)
        asleep.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        asleep.sendall(f"GET /events HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n\r\n".encode())
        viewer = Viewer(self.port)
        viewer.wait(lambda event: event["kind"] == "snapshot")
        self.fly(TASK)
        viewer.wait(lambda event: event.get("execution", None) and event["execution"]["state"] == "ended")
        self.assertEqual(viewer.numbers[1:], list(range(viewer.numbers[0] + 1, viewer.numbers[-1] + 1)))


class Doors(OnBus):
    def setUp(self):
        super().setUp()
        self.process = self.watch()

    def test_a_page_of_another_origin_or_under_another_name_gets_nothing(self):
        ours = f"127.0.0.1:{self.port}"
        self.assertEqual(self.ask().status, 200)
        self.assertEqual(self.ask(Host=f"localhost:{self.port}").status, 200)
        self.assertEqual(self.ask("/events", Origin=f"http://{ours}").status, 200)
        self.assertEqual(self.ask(Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="navigate").status, 200)
        for headers in ({"Host": "evil.example"}, {"Host": f"evil.example:{self.port}"}, {"Host": "127.0.0.1"}, {"Host": f"127.0.0.1:{self.port}.evil.example"},
                        {"Host": None}, {"Host": ""}, {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": f"https://{ours}"},
                        {"Origin": f"http://{ours}.evil.example"}, {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"},
                        {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Mode": "cors"}):
            for path in ("/", "/events"):
                with self.subTest(f"{path} {headers}"):
                    answer = self.ask(path, **headers)
                    self.assertIn(answer.status, (400, 403))  # microhttpd itself wants a Host
                    self.assertNotIn(b"ssv", answer.read())

    def test_nothing_else_is_there_and_nothing_is_taken(self):
        for path in ("/etc/passwd", "/../report.html", "/events/", "//", "/favicon.ico"):
            self.assertEqual(self.ask(path).status, 404, path)
        for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS"):
            self.assertEqual(self.ask("/", method).status, 405, method)
        answer = self.ask()
        self.assertIn("frame-ancestors 'none'", answer.getheader("Content-Security-Policy"))
        self.assertEqual((answer.getheader("Cross-Origin-Resource-Policy"), answer.getheader("Cache-Control")), ("same-origin", "no-store"))
        self.assertIsNone(answer.getheader("Access-Control-Allow-Origin"))

    def test_it_listens_on_loopback_alone(self):
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", self.port), timeout=5)
        listening = {int(line.split()[1].split(":")[1], 16): line.split()[1].split(":")[0] for line in Path("/proc/net/tcp").read_text().splitlines()[1:]}
        self.assertEqual(listening[self.port], "0100007F")

    def test_garbage_instead_of_http_ends_no_watch(self):
        draw = random.Random(2)
        for _ in range(40):
            with socket.create_connection(("127.0.0.1", self.port), timeout=5) as connection:
                connection.sendall(draw.randbytes(draw.randrange(1, 5000)))
        self.assertEqual(self.ask().status, 200)

    def test_more_viewers_than_there_is_room_for_leave_those_alone_who_are_there(self):
        viewer = Viewer(self.port)
        viewer.wait(lambda event: event["kind"] == "snapshot")
        crowd = [socket.create_connection(("127.0.0.1", self.port), timeout=5) for _ in range(100)]
        for connection in crowd:
            connection.close()
        planner = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", self.url], stderr=subprocess.DEVNULL)
        self.addCleanup(planner.wait)
        self.addCleanup(planner.terminate)
        viewer.wait(lambda event: event["kind"] == "planners")

    def test_signals_end_it_with_viewers_there(self):
        viewer = Viewer(self.port)
        viewer.wait(lambda event: event["kind"] == "snapshot")
        self.process.send_signal(signal.SIGINT)
        self.assertEqual(self.process.wait(10), OK)
        self.assertIn("heard 0 messages", self.process.stderr.read())


class Refused(OnBus):
    def run_watch(self, *options):
        return subprocess.run([BIN / "ssv", "watch", *options], capture_output=True, text=True, timeout=20)

    def test_what_cannot_be(self):
        self.watch()
        taken = self.run_watch("--lcm", self.url, "--port", str(self.port))
        self.assertEqual(taken.returncode, FAILED)
        self.assertIn(f"127.0.0.1:{self.port}", taken.stderr)
        self.assertIn("--port", taken.stderr)
        no_bus = self.run_watch("--port", "0", "--lcm", "nonsense://")
        self.assertEqual(no_bus.returncode, NO_ANSWER)
        for options, said in ((["--port", "70000"], "--port 70000"), (["--port", "x"], "--port x"), (["file"], "no arguments")):
            done = self.run_watch(*options)
            self.assertEqual(done.returncode, USAGE)
            self.assertIn(said, done.stderr)
        help_ = self.run_watch("--help").stdout
        for word in ("Examples:", "Exit codes:", "sends nothing"):
            self.assertIn(word, help_)


if __name__ == "__main__":
    unittest.main(verbosity=2)
