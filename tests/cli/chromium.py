# SPDX-License-Identifier: MIT
"""A headless Chromium, operated over its debugging pipe with the standard library alone."""

import base64
import json
import os
import select
import shutil
import subprocess
import time


def browser_path():
    return shutil.which("chromium") or shutil.which("chromium-browser")


class Page:
    """One page. `problems` has every console error, exception and failed request, `requests` every address."""

    def __init__(self, profile, width=1280, height=900):
        to_browser, self.out = os.pipe()
        self.inp, from_browser = os.pipe()

        # The browser reads descriptor 3 and writes 4.
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{to_browser} 4>&{from_browser}', "browser", browser_path(),
             "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--use-gl=angle",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe",
             f"--user-data-dir={profile}", f"--window-size={width},{height}", "about:blank"],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.number, self.rest, self.session = 0, b"", None
        self.problems, self.requests = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self.call(domain + ".enable")
        self.call("Emulation.setScrollbarsHidden", hidden=True)
        self.resize(width, height)

    def call(self, method, **arguments):
        self.number += 1
        message = {"id": self.number, "method": method, "params": arguments}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            for answer in self.messages(1):
                if answer.get("id") == self.number:
                    if "error" in answer:
                        raise RuntimeError(method + ": " + json.dumps(answer["error"]))
                    return answer["result"]
        raise RuntimeError(method + ": no answer of the browser")

    def messages(self, patience):
        if b"\0" not in self.rest and select.select([self.inp], [], [], patience)[0]:
            self.rest += os.read(self.inp, 1 << 20)
        *whole, self.rest = self.rest.split(b"\0")
        answers = [json.loads(each) for each in whole]
        for each in answers:
            self.note(each)
        return answers

    def note(self, message):
        method, about = message.get("method"), message.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(about["request"]["url"])
        elif method == "Network.webSocketCreated":
            self.requests.append(about["url"])
        elif method == "Runtime.exceptionThrown":
            self.problems.append(json.dumps(about["exceptionDetails"])[:400])
        elif method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning", "assert"):
            self.problems.append(json.dumps(about["args"])[:400])
        elif method == "Log.entryAdded" and about["entry"]["level"] in ("error", "warning"):
            if "GPU stall" not in about["entry"]["text"]:  # of software rendering, when a picture is read
                self.problems.append(about["entry"]["text"])

    def value(self, script):
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True)
        return result["result"].get("value")

    def wait(self, script, patience=20):
        """Waits until a script gives something true; returns it. None after `patience` seconds."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            value = self.value(script)
            if value:
                return value
            self.messages(0.05)
        return None

    def open(self, url):
        self.call("Page.navigate", url=url)

    def resize(self, width, height, dark=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def box(self, selector):
        return self.value("(() => { const e = document.querySelector(%s); e.scrollIntoView({block: 'nearest'});"
                          "const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()"
                          % json.dumps(selector))

    def mouse(self, kind, x, y):
        held = 0 if kind == "mouseReleased" else 1
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=held, clickCount=1)

    def drag(self, begin, end, steps=20):
        self.mouse("mousePressed", *begin)
        for n in range(1, steps + 1):
            self.mouse("mouseMoved", *(a + (b - a) * n / steps for a, b in zip(begin, end)))
            self.messages(0.01)
        self.mouse("mouseReleased", *end)

    def picture(self, file, whole=False):
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        with open(file, "wb") as out:
            out.write(base64.b64decode(data))

    def close(self):
        self.process.kill()
        self.process.wait()
