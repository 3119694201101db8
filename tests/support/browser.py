"""A headless Chromium that a test drives: opens one page, evaluates in it, presses keys, takes pictures, and keeps whatever the page
complains of or asks the network for."""
import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

CHROMIUM = shutil.which("chromium")
DEADLINE_S = 120  # generous: reached only when something is broken


class Browser:
    """`with Browser() as browser`; leaving the block ends it and removes its files."""

    def __init__(self, width=1280, height=1000, options=()):
        self.size, self.options = (width, height), options

    def __enter__(self):
        self.folder = tempfile.mkdtemp()
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()

        def take_pipes():  # Chromium reads commands from 3 and answers on 4
            read, write = os.dup(theirs_in), os.dup(theirs_out)
            os.dup2(read, 3)
            os.dup2(write, 4)

        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", f"--user-data-dir={self.folder}",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run", "--disable-extensions",
             "--disable-component-update", "--disable-background-networking", "--disable-sync", "--hide-scrollbars",
             "--force-device-scale-factor=1", f"--window-size={self.size[0]},{self.size[1]}", *self.options, "about:blank"],
            stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log, preexec_fn=take_pipes, pass_fds=(3, 4, theirs_in, theirs_out))
        os.close(theirs_in)
        os.close(theirs_out)
        self.input, self.output, self.rest = ours_in, ours_out, b""
        self.number, self.answers, self.events = 0, {}, []
        target = next(one for one in self.call("Target.getTargets")["targetInfos"] if one["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.page(f"{domain}.enable")
        self.page("Emulation.setDeviceMetricsOverride", width=self.size[0], height=self.size[1], deviceScaleFactor=1, mobile=False)
        return self

    def __exit__(self, *_):
        """Ends it, politely if it still listens."""
        with contextlib.suppress(Exception):
            self.call("Browser.close")
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.input)
        os.close(self.output)
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    # ---- The protocol: JSON with a zero byte behind ----

    def _take(self, deadline_s):
        while b"\0" not in self.rest:
            if not select.select([self.input], [], [], max(0, deadline_s - time.monotonic()))[0]:
                raise TimeoutError("Chromium says nothing")
            block = os.read(self.input, 1 << 20)
            if not block:
                self.log.seek(0)
                raise ConnectionError("Chromium has ended:\n" + self.log.read().decode(errors="replace"))
            self.rest += block
        text, _, self.rest = self.rest.partition(b"\0")
        message = json.loads(text)
        if "id" in message:
            self.answers[message["id"]] = message
        else:
            self.events.append(message)

    def call(self, method, session=None, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.output, json.dumps(message).encode() + b"\0")
        deadline_s = time.monotonic() + DEADLINE_S
        while self.number not in self.answers:
            self._take(deadline_s)
        answer = self.answers.pop(self.number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def page(self, method, **parameters):
        return self.call(method, self.session, **parameters)

    # ---- What a test does ----

    def open(self, url):
        """Opens the page and waits until it has loaded."""
        self.events.clear()
        self.page("Page.navigate", url=url)
        self.wait("document.readyState === 'complete' && location.href !== 'about:blank'")

    def evaluate(self, expression):
        answer = self.page("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description", str(answer["exceptionDetails"])))
        return answer["result"].get("value")

    def wait(self, expression):
        deadline_s = time.monotonic() + DEADLINE_S
        while not self.evaluate(expression):
            if time.monotonic() > deadline_s:
                raise TimeoutError(f"never true: {expression}")
            time.sleep(0.02)

    def press(self, key, shift=False):
        text = {"Space": " "}.get(key, key)
        named = {"key": text, "modifiers": 8 if shift else 0}
        if len(text) == 1:
            named["text"] = text
        self.page("Input.dispatchKeyEvent", type="keyDown", **named)
        self.page("Input.dispatchKeyEvent", type="keyUp", **named)

    def screenshot(self, path, last=None):
        """The picture of the page, all of it or down to the end of an element."""
        clip = {}
        if last:
            bottom = self.evaluate(f"document.querySelector({last!r}).getBoundingClientRect().bottom + scrollY")
            clip = {"clip": {"x": 0, "y": 0, "width": self.size[0], "height": bottom, "scale": 1}}
        picture = self.page("Page.captureScreenshot", captureBeyondViewport=True, **clip)
        Path(path).write_bytes(base64.b64decode(picture["data"]))

    def complaints(self):
        """What the page's console and the browser's log say, exceptions included."""
        told = []
        for event in self.events:
            what = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                told.append(what["exceptionDetails"].get("exception", {}).get("description", str(what)))
            elif event["method"] == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
                told.append(" ".join(str(argument.get("value", "")) for argument in what["args"]))
            elif event["method"] == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
                told.append(what["entry"]["text"])
        return told

    def requests(self):
        """The addresses that the page asked for, its own included."""
        return [event["params"]["request"]["url"] for event in self.events if event["method"] == "Network.requestWillBeSent"]
